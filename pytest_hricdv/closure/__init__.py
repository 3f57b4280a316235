"""Closure: from the runs to the report model, and all that follows from it. Plain data, no pytest."""
