"""Kills sessions at random moments, resumes or rebuilds them, and counts what was lost."""
