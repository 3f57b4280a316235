"""Physics engines: which one runs the tests, and two that check each other."""
