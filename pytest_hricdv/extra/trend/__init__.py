"""The trend over sessions: a line on each in the file of `--hri-history`."""
