"""Suggestions: requirements that all runs of a suite satisfied, ranked by the seeded faults that only they notice.

stored_run         a run as it is stored, to be judged by requirements that nobody had thought of when it was made
process            records runs of the code, as it is and with seeded faults
recordings         which runs are made, and where they are kept
views              what happened in runs: events, and conditions with the times at which they hold
candidate          a requirement that may be suggested
responses, ...     one form of requirements each: what of it all runs satisfied
checking           judges stored runs by candidates
ranking            which candidates say what no other one says, the most useful ones first
suggesting         all of that, after the last test of a session
"""
