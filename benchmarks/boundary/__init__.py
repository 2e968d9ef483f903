"""Random boundary problems: success rates, costs of solutions, and distances of other curves."""
