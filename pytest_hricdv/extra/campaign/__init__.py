"""Campaigns: each test of a suite runs with many seeds, on one machine or many; an interrupted campaign resumes.

`plan` says what runs, `store` keeps each run, `execution` sends missing runs to a cluster and repeats some elsewhere,
`reporting` sums up all runs, and `view` and `table` show them. Tests run in processes of `session.run_process`.
"""
