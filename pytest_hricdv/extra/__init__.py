"""Optional features, a folder each. No other package imports them: see `pytest_hricdv.registry`."""
