"""The repeatability audit: reruns some tests, each alone in a fresh process, and compares the records.

choice          which tests
repeating       fresh processes, and what tests come to there
process         such a process, from inside
sources         what a run may read beside its test, such as clocks, and runs in which it stands still
difference      the first event at which two runs differ
diagnosis       why: by experiment
"""
