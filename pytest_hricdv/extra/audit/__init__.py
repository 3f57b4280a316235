"""The repeatability audit: some tests run again, alone in a fresh process, and give the same record.

choice          which tests
repeating       fresh processes, and what tests come to there
process         such a process, from inside
sources         what a run may read beside its test, such as clocks, and runs in which it stands still
difference      the first event at which two runs differ
diagnosis       why: by experiment
"""
