"""How fast suites reach points, and what each strategy of the closing loop contributes.

__main__   runs the sessions, writes docs/studies/closure.md and its picture
growth     the points that a session reached, run by run
tables     the page's tables
"""
