"""Runs as MCAP files, which the viewers and tools of robotics open."""
