"""Runs of a multi-agent system: loading, environment, scheduling, end of runs, traces."""
