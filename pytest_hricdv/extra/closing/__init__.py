"""The closing loop: search-based test generation in which the targets that are still open decide what runs next.

Vocabulary
    point                 something that a run can hit: a statement, a branch, a plan, a verdict, a bin, ...
    target                a point to hit; it is open until a run has hit it
    archive               all runs so far: which targets are open, and the best run for each point
    strategy              proposes tests from the archive
    proposal              a test that a strategy proposes, with its targets
    generation            the proposals that run before anything new is learned
    bandit                shares the tests of a generation among the strategies, by what they have hit recently
    pool                  the abstract tests that exploring the model gives
    interaction           a part of a test: what a person and the robot do from one request to the next; a cross product
                          with `planned` says which coordinates of its bin an interaction plans
    intervention          one disturbance in an interaction, after a number of its commands, with its parameters
    combination           the interventions in one interaction; an empty one leaves it undisturbed
    outcome               how an interaction ends, by the coordinates of one cross product that are not planned
    effect                how an interaction ends, by all cross products
    nominal effect        the most frequent one of an undisturbed interaction
    deviation             a combination whose most frequent effect is not the nominal one, and this effect
    missing condition     what an effect misses to be a wanted one: a character of a pattern, or the effect as a whole
    experience            what all runs have shown of interactions: a surrogate model of outcomes per cross product

Constants of the strategies: half and twice their values change the share of open targets less than another seed does,
by -7 to +1 points instead of up to 12 (six made-up handovers).

Modules
    loop, strategy                  the loop with its bandit, independent of the strategies; the archive
    targets                         the points to hit; what came closest to those left open
    observation                     what one run yields: points, distances, categories of violations
    evidence, suite                 what the loop has shown; the smallest suite that hits as much, and its cache
    pool                            abstract tests, and the interactions in them
    outcome_model, experience       surrogate models of interactions, and what their effects lack
    combination_synthesis           combinations that were never tried, from what interventions bring about alone
    selection                       the test that will probably hit most open bins
    NAME_strategy                   the strategies; `violation_strategy` searches for violations after the loop
    process, runs                   the process that runs tests, each in a fork; the session's end of it
    progress                        how far the loop is, in the terminal and for viewers
    closing, feature, records, view the loop in a session, and in its report

All but `process`, `runs`, `progress` and `closing` are independent of pytest: a run is a function.
"""
