"""A pytest session: what is collected, run, reported, and done when all tests have run."""
