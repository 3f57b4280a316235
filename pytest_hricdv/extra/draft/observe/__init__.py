"""Observation of code while it runs: what crosses its border, as the tracer and the stand-ins of a draft see it.

Nothing in here imports more than the standard library: the tracer runs in processes that have nothing else.
"""
