"""The project that is written: what all its files share, and a module for each file."""
