"""Results: typed records of tests and reports, built once, serialized once, and read by every view."""
