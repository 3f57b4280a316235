"""The paper's experiment: all four ways to generate tests, side by side with the published figures."""
