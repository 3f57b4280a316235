"""Physics engines: the choice of the one that runs the tests, and the cross-check of two."""
