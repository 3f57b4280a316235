"""Classes of a drafted `ports.py` as texts with gaps, which the modules above fill in."""
