"""Studies of the home-care example: each is a command, `python -m studies.NAME`.

- `published`: the published tests as suites, and the published figures recomputed from the data
- `comparison`: this robot beside the published one, test by test
"""
