"""Answers about a report for other programs: as JSON, and by the Model Context Protocol."""
