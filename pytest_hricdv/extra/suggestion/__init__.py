"""Suggestion: requirements that all runs of a suite satisfied, ranked by the seeded bugs that violate them.

stored_run      a run on disk, to be judged by requirements that did not exist when it was made
process         the process that records runs, of the code as it is and with seeded bugs
recordings      which runs are made, and where they are kept
events          what happened in runs: instants, and conditions with the spans in which they held
candidate       a requirement that may be suggested
order_templates, bounds
                templates (Dwyer, Avrunin, Corbett: Patterns in Property Specifications, ICSE 1999)
mining          candidates that all runs satisfy, ranked by the seeded bugs that violate them
suggest         all of that, after the last test of a session
"""
