"""Workers beyond one process."""
