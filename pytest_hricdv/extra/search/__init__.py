"""Shrinking failing tests, and searching for violations of requirements, after the tests of a session."""
