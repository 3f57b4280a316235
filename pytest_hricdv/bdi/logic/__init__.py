"""What can be concluded from terms and formulas: substitution, unification, inference."""
