"""The project that is written: what all its files share, a module for each file, and the pieces of long ones."""
