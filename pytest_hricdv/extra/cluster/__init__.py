"""Work beyond one process, or one machine: workers of Dask distributed, each with a process in which runs take place.

`address` says which cluster, `connection` leads to its scheduler, `cluster` hands out work and takes what comes back,
`service` is the worker's side of it, `code_archive` and `worker_project` bring the project there, and `remote` is what
others use of all this.
"""
