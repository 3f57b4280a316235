"""Foundations of all other packages: error messages, input files, atomic files, grammars."""
