"""Errors of a run in virtual time."""

from __future__ import annotations


class KernelError(Exception):
    """A node failed or misused the kernel; the text names the node and the simulated time."""


class TerminalInterrupt(KeyboardInterrupt):
    """Somebody in a run has pressed ctrl-c: what is raised in the code that has this terminal, and ends it at most."""


class NodeError(KernelError):
    """A node failed: it raised the exception that is the cause, or, without a cause, keeps time from passing.

    Args:
        node: its name.
        time_s: when it failed (s of simulated time).
        failure: what happened.
    """

    def __init__(self, node: str, time_s: float, failure: str) -> None:
        super().__init__(f"{node} {failure}")
        self.node = node
        self.time_s = time_s
