"""The repeatability audit: reruns some tests, each alone in a fresh process, and compares the records.

- `auditor`: which tests rerun, and the first event at which two runs differ
- `repeating`: reruns of tests in fresh processes
- `process`: the code of such a process
- `sources`: sources of nondeterminism, such as clocks, and runs in which they are frozen
- `diagnosis`: experiments that find out why
"""
