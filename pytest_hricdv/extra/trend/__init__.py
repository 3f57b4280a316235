"""The trend over sessions: the file of `--hri-history` has a line for each."""
