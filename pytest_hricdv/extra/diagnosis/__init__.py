"""Diagnosis: why tests fail, and where in the code.

    failures      what failed in a test: a requirement, in a state of the code, after which disturbances
    spectrum      which statements failing tests execute, and passing ones do not
    grouping      failures that have probably one cause
    experiments   runs that confirm it: the test without what it is thought to fail for

A cause is what makes a failure go away: failures that go away with the same change to their tests, in the same state of
the code under test, at the same places in it, have one cause (A. Zeller: Why Programs Fail, 2nd edition, 2009, chapters
12 and 13). Before any experiment this is a hypothesis, by association over all tests of a report.
"""
