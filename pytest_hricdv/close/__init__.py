"""Closes the loop: what is not covered yet drives what is generated next."""
