"""What happened in a run: its result, and its trace: which event led to which plan of which agent, and to which action.

A traced run notes a :class:`Step` for a percept or belief gained or lost, a goal, a selected plan, an action, a message
and a print. Each names the step that caused it, across agents, so that an action can be followed back to the belief
that it was selected for. Tracing is done by subclasses of the run and its agents, in ``tracing``: plain runs have no
overhead.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import NamedTuple


@dataclass(frozen=True, slots=True)
class Step:
    """One step of a traced run.

    Args:
        number: its index in the trace, from 1.
        round: the round, from 1; 0 for what there is before the first.
        agent: the agent it happened in.
        kind: "percept", "belief", "goal" or "failure" (events), "plan", "action", "message", "print", "warning".
        text: what it is, as AgentSpeak or as the text printed; for a plan its label and trigger.
        cause: the number of the step that caused it; None for what comes from outside.
        plan: the label of the plan selected, or of the plan that did it, else empty.
        place: for a plan, where it is in the sources, as ``file:line``.
        beliefs: for a plan, the beliefs that made its context true, with their sources.
    """

    number: int
    round: int
    agent: str
    kind: str
    text: str
    cause: int | None = None
    plan: str = ""
    place: str = ""
    beliefs: tuple[str, ...] = ()

    def __str__(self) -> str:
        text = f"{self.kind} {self.text}"
        if self.beliefs:
            text += f" because of {', '.join(self.beliefs)}"
        if self.place:
            text += f" ({self.place})"
        return text


@dataclass(frozen=True, slots=True)
class Trace:
    """The steps of a run in the order in which they happened."""

    steps: tuple[Step, ...]

    def __iter__(self) -> Iterator[Step]:
        return iter(self.steps)

    def __len__(self) -> int:
        return len(self.steps)

    def of(self, agent: str, kind: str | None = None) -> tuple[Step, ...]:
        """The steps of an agent, of all kinds or of one."""
        return tuple(step for step in self.steps if step.agent == agent and kind in (None, step.kind))

    def why(self, step: Step) -> tuple[Step, ...]:
        """The chain of causes of a step, from the first to the step itself."""
        chain = [step]
        while chain[-1].cause is not None:
            chain.append(self.steps[chain[-1].cause - 1])
        return tuple(reversed(chain))

    def text(self, agent: str | None = None) -> str:
        """The trace, or one agent's part of it, as lines of number, round, agent, step, and cause."""
        shown = [step for step in self.steps if agent in (None, step.agent)]
        width = max((len(step.agent) for step in shown), default=0)
        return "\n".join(_line(step, width) for step in shown)

    def chain_text(self, step: Step) -> str:
        """The chain of causes as text, each step indented more than its cause."""
        chain = self.why(step)
        return "\n".join(f"{'  ' * depth}[round {each.round}] {each.agent}: {each}" for depth, each in enumerate(chain))

    def to_json(self) -> str:
        """The steps as a JSON list of objects."""
        return json.dumps([asdict(step) for step in self.steps], ensure_ascii=False)


def _line(step: Step, width: int) -> str:
    cause = f"  <- {step.cause}" if step.cause is not None else ""
    return f"{step.number:>4}  round {step.round:<4} {step.agent:<{width}}  {step}{cause}"


class Result(NamedTuple):
    """What happened in a run.

    A named tuple because learning makes thousands: a frozen dataclass takes four times as long.

    Args:
        prints: what the agents printed, as ``[agent] text``, in order.
        plans: for each agent, the labels of the plans it executed, in order; labels that begin with ``_``
            are automatic, of plans without a label.
        actions: the external actions, as pairs of agent and AgentSpeak text, in order.
        rounds: the number of rounds done.
        ended: how it ended: "idle" (nothing left to do), "spin" (the agents only repeat
            themselves), "goal" (the given goal was achieved), "round limit", or "stopped"
            (by ``.stopMAS``).
        warnings: what the models' author should know, such as goals that failed unhandled.
        time_ms: virtual time at the end, in ms.
        trace: the trace, if it was requested.
    """

    prints: list[str]
    plans: dict[str, list[str]]
    actions: list[tuple[str, str]]
    rounds: int
    ended: str
    warnings: list[str]
    time_ms: float
    trace: Trace | None = None
