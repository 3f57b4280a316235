"""Campaigns: the tests of suites with many seeds each, on one machine or many, resumable.

`plan` says what is run, `store` keeps each run, `execution` lets a cluster do what is missing, `audit` has some runs
repeated elsewhere, `statistics` sums up, and `reporting`, `page` and `table` show it. The process that runs tests is
`session.run_process`.
"""
