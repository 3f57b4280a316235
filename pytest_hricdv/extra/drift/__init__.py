"""Drift: what the code under test has, and its testbench and model lack.

drifting           compares what is found in the code with what the testbench declares, and with what runs did
proposal           the lines that a testbench lacks, as a change of its conftest file
command            `python -m pytest_hricdv init --update`, which tells both
"""
