"""What is suggested from runs of three testbenches, for docs/suggestions.md."""
