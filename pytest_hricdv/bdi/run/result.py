"""What happened in a run."""

from __future__ import annotations

from typing import NamedTuple

from pytest_hricdv.bdi.run.scheduler import Run
from pytest_hricdv.bdi.run.trace import Trace
from pytest_hricdv.bdi.run.tracing import TracedRun


class Result(NamedTuple):
    """What happened in a run.

    A named tuple because one is made for every run: a frozen dataclass takes four times as long.

    Args:
        prints: what the agents printed, as ``[agent] text``, in order.
        plans: for each agent, the labels of the plans it executed, in order; labels that begin with ``_``
            are automatic, of plans their author gave none.
        actions: the external actions, as pairs of agent and AgentSpeak text, in order.
        rounds: the number of rounds done.
        ended: how it ended: "idle" (nothing left to do), "spin" (agents that only look again and again
            for what never comes), "goal" (the goal asked for was achieved), "round limit", or "stopped"
            (by ``.stopMAS``).
        warnings: what the models' author should know, such as goals that failed unhandled.
        time_ms: virtual time at the end, in ms.
        trace: what led to what, if that was asked for.
    """

    prints: list[str]
    plans: dict[str, list[str]]
    actions: list[tuple[str, str]]
    rounds: int
    ended: str
    warnings: list[str]
    time_ms: float
    trace: Trace | None = None

    @classmethod
    def of(cls, run: Run, ended: str) -> Result:
        """The result of a run that has ended."""
        plans = {name: agent.executed for name, agent in run.agents.items()}
        trace = Trace(tuple(run.steps)) if isinstance(run, TracedRun) else None
        return cls(run.prints, plans, run.actions, run.rounds, ended, run.warnings, run.time_ms, trace)
