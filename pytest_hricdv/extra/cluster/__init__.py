"""Distributed execution: Dask workers, each with a process in which runs take place.

`feature` has the options and the interface that the rest of the plugin uses, `connection` leads to the scheduler,
`cluster` hands out requests and takes answers, `service` is the worker's side, and `code_archive` brings the project
to workers.
"""
