"""How fast suites reach points, and what each way of the closing loop brings.

__main__   runs the sessions, writes docs/closure.md and its picture
growth     the points that a session reached, run by run
tables     the page's tables
"""
