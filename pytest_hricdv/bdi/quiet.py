"""Noticing that the agents of a run only repeat themselves."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from pytest_hricdv.bdi.language.syntax_tree import variables_of
from pytest_hricdv.bdi.language.terms import Variable

if TYPE_CHECKING:
    from .agent import Agent
    from .intentions import Frame, Intention
    from .scheduler import Run

QUIET_ROUNDS = 40
"""Rounds without any change of the world before the run is watched for agents that only spin."""


class Quiet:
    """Notices that the agents only repeat themselves.

    When nothing has changed for a while and the mental states of all agents are what they were before,
    nothing will ever change, except by time. Whether anything has changed is looked at every now and then;
    once nothing has, the states are compared after every round.
    """

    def __init__(self, run: Run) -> None:
        self._run = run
        self.due = QUIET_ROUNDS
        """The round after which :meth:`spinning` has to be asked next."""
        self._progress = 0
        self._outlines: set[int] = set()
        self._states: set[str] = set()
        self._progress_at_jump = -1
        self._states_at_jumps: set[str] = set()

    def spinning(self) -> bool:
        """After a round: whether the agents repeat themselves, waits for time aside."""
        run = self._run
        if run.progress != self._progress:
            self._progress = run.progress
            self.due = run.rounds + QUIET_ROUNDS
            self._forget()
            return False
        self.due = run.rounds + 1
        # States are long for deep intentions: they are written out only when their outline has come before.
        outline = mental_outline(run)
        if outline not in self._outlines:
            self._outlines.add(outline)
            return False
        state = mental_states(run, with_waits=False)
        if state in self._states:
            self._forget()
            return True
        self._states.add(state)
        return False

    def _forget(self) -> None:
        self._outlines.clear()
        self._states.clear()

    def polling(self) -> bool:
        """After a jump in time: whether the agents only wait and look again, over and over."""
        run = self._run
        if run.progress != self._progress_at_jump:
            self._progress_at_jump = run.progress
            self._states_at_jumps.clear()
            return False
        state = mental_states(run, with_waits=True)
        if state in self._states_at_jumps:
            return True
        self._states_at_jumps.add(state)
        return False


def mental_outline(run: Run) -> int:
    """A number that is the same for the same mental states, and for few others."""
    parts: list[object] = []
    for agent in run.interpreted().values():
        parts.append((len(agent.events), len(agent.intentions)))
        parts += [(event.sign, event.literal if event.literal.ground else event.literal.key) for event in agent.events]
        parts += [len(_remembered(agent, event.intention)) for event in agent.events]
        for intention in agent.intentions:
            top = intention.frames[-1]
            about = top.literal if top.literal.ground else top.literal.key
            parts.append((len(_remembered(agent, intention)), top.plan.label, top.pc, about))
    return hash(tuple(parts))


def _remembered(agent: Agent, intention: Intention | None) -> list[Frame]:
    """The plans of an intention but for those that can make no difference any more."""
    if intention is None or not intention.frames:
        return []
    *waiting, top = intention.frames
    return [frame for frame in waiting if not (frame.is_at_end and agent.library.forgets(frame.plan))] + [top]


def mental_states(run: Run, with_waits: bool) -> str:
    """All agents' events and intentions as text, with variables numbered as they appear."""
    parts = []
    for name, agent in run.interpreted().items():
        parts.append(f"{name}:")
        parts += [f"{event}<{_intention_text(agent, event.intention)}>" for event in agent.events]
        parts += [_intention_text(agent, intention) for intention in agent.intentions]
        if with_waits:
            for wait in agent.waits:
                left = None if wait.deadline is None else wait.deadline - run.ticks
                parts.append(f"{left} {_intention_text(agent, wait.intention)}")
    numbers: dict[str, int] = {}
    return re.sub(r"\b_\d+\b", lambda found: f"_{numbers.setdefault(found[0], len(numbers))}", "\n".join(parts))


def _intention_text(agent: Agent, intention: Intention | None) -> str:
    return "|".join(
        f"{frame.plan.label}@{frame.pc}/{id(frame.body)}/{len(frame.blocks)} {frame.sign}{frame.literal} "
        f"{[f'{variable}={frame.unifier[variable]}' for variable in _variables(frame)]} "
        f"{[len(loop.solutions) for _, _, loop in frame.blocks if loop is not None]}"
        f"{len(frame.loop.solutions) if frame.loop else ''}"
        for frame in _remembered(agent, intention)
    )


def _variables(frame: Frame) -> list[Variable]:
    """The variables bound in a plan that its body could still look at."""
    return sorted(variables_of(frame.plan.body) & frame.unifier.keys())
