"""Experiments with single tests: making a failing test shorter, and looking for a test that violates a requirement.

    budget                of runs and seconds
    shrink                shortens a failing test for as long as it fails the same way
    failure_signature     the parts of a requirement that a violation made false: equal ones are the same failure
    evolution_strategy    varies the parameters of tests to minimize the margin of a requirement

Independent of the domain and of pytest: a run is a function passed as an argument.
"""
