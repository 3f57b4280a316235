"""Detects what no run of a session used: influences on the code under test, and parameters of the run.

Both are observed, and neither is visible in the verdicts: a testbench that reaches nothing passes every test.
"""
