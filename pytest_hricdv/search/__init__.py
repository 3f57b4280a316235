"""Further runs of single tests: shrinking failing tests, searching for violations, replaying a run exactly.

    budget                how many runs and seconds a search may take
    evolution_strategy    the search for a violation of a requirement
    shrink                the reduction of a failing test
    failure_signature     which part of a requirement failed
    replay                replay files

Independent of the domain: a test is a list of actions with parameters, and a run is a function passed as an argument.
"""
