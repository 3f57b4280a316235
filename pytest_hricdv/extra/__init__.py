"""Optional parts, one folder a feature. Nothing below imports them: see `pytest_hricdv.registry`."""
