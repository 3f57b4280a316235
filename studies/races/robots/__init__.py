"""The robots: code under test, one module each."""
