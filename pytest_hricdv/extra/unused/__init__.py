"""What no run of a session used: an influence on the code under test, a parameter of the run.

Both are observed, and neither is visible in the verdicts: a testbench that reaches nothing passes every test.
"""
