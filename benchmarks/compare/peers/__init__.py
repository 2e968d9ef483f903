"""One module for each library that is timed; each runs in a process, and but for ours in an environment, of its own."""
