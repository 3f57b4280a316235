"""Qualification: does this installation find what it has to find? Known answers, and a page to sign."""
