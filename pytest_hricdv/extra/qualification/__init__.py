"""Qualification: checks an installation against known answers, and writes a page to sign."""
