"""Random boundary problems: how many are solved, what solutions cost, how near other curves come."""
