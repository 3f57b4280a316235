"""What fails on the unchanged controller."""
