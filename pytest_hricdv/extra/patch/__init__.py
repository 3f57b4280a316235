"""Coverage of a patch: which of the statements that changed since a revision are executed, and by which tests."""
