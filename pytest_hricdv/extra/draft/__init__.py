"""A draft of a testbench, made of the code that is to be tested: what it says, hears, its states, how it waits.

`analysis.analyse` reads a package without importing it, and returns `findings.Findings`, which are plain data.
"""
