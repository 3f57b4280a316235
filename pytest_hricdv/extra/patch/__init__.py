"""Patch coverage: which statements that changed since a revision are executed, and by which tests."""
