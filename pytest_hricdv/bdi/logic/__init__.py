"""Reasoning with terms and formulas: substitution, unification, inference."""
