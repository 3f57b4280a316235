"""Which event led to which plan of which agent in which round, and what came of it.

A traced run notes a :class:`Step` whenever something comes about: a percept or belief gained or lost, a goal,
a plan chosen, an action, a message, a print. Each names the step that it came from, across agents, so that a
human's action can be followed back to the belief that was chosen for it. Runs that are not traced use none of
this: tracing is done by subclasses of the run and its agents, in ``traced``.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass


@dataclass(frozen=True, slots=True)
class Step:
    """One thing that came about in a run.

    Args:
        number: its place in the trace, from 1.
        round: the round, from 1; 0 for what there is before the first.
        agent: the agent it came about in.
        kind: "percept", "belief", "goal" or "failure" (events), "plan", "action", "message", "print", "warning".
        text: what it is, as AgentSpeak or as the text printed; for a plan its label and trigger.
        cause: the number of the step that it came from; None for what comes from outside.
        plan: the label of the plan chosen, or of the plan that did it, else empty.
        place: for a plan, where it is in the sources, as ``file:line``.
        beliefs: for a plan, the beliefs that its context was found true by, with their sources.
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
    """The steps of a run in the order in which they came about."""

    steps: tuple[Step, ...]

    def __iter__(self) -> Iterator[Step]:
        return iter(self.steps)

    def __len__(self) -> int:
        return len(self.steps)

    def of(self, agent: str, kind: str | None = None) -> tuple[Step, ...]:
        """The steps of an agent, of all kinds or of one."""
        return tuple(step for step in self.steps if step.agent == agent and kind in (None, step.kind))

    def why(self, step: Step) -> tuple[Step, ...]:
        """What a step came from: the chain of causes from the first to the step itself."""
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
        """What a step came from, the first cause first, each step further in than the one it came from."""
        chain = self.why(step)
        return "\n".join(f"{'  ' * depth}[round {each.round}] {each.agent}: {each}" for depth, each in enumerate(chain))

    def to_json(self) -> str:
        """The steps as a JSON list of objects."""
        return json.dumps([asdict(step) for step in self.steps], ensure_ascii=False)


def _line(step: Step, width: int) -> str:
    cause = f"  <- {step.cause}" if step.cause is not None else ""
    return f"{step.number:>4}  round {step.round:<4} {step.agent:<{width}}  {step}{cause}"
