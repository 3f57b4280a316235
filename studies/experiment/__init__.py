"""The paper's experiment: all four methods that generate tests, beside the published figures."""
