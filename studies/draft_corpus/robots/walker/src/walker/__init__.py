"""Controller of a smart walking frame."""
