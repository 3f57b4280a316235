"""`LaneRecord` makes a test of what several interactive people did in a run.

`OnlinePeople` reports each action to it. Each person is a lane of the test; the order between lanes (`causes`) and the
pauses of each person become parameters of its actions.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, replace

from pytest_hricdv.bdi.language.syntax import Program
from pytest_hricdv.bdi.run.tracing import Trace
from pytest_hricdv.generate.actors import PAUSE_S, TURN, TURN_WAIT_S, TURNS, stay_of
from pytest_hricdv.generate.causes import causes
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.runtime.kernel import US_PER_S


@dataclass(frozen=True)
class ActionStart:
    """An action that has begun.

    Args:
        number: its number in the test, from 1.
        actor: who does it.
        free_us: since when its actor was free.
        begun_us: when it began.
    """

    number: int
    actor: str
    free_us: int
    begun_us: int


class LaneRecord:
    """Records which actor began and ended which action in a run."""

    def __init__(self) -> None:
        self._begun: list[ActionStart] = []
        self._done_us: dict[int, int] = {}
        self._done_before: dict[int, frozenset[int]] = {}
        """Action -> the actions that had ended when it began."""
        self._stays_us: dict[str, int] = {}
        self._given_up: set[int] = set()

    def begin(self, action: ActionStart) -> None:
        """An action begins."""
        self._begun.append(action)
        self._done_before[action.number] = frozenset(self._done_us)

    def end(self, number: int, now_us: int) -> None:
        """An action has ended."""
        self._done_us[number] = now_us

    def drop(self, number: int) -> None:
        """The agent has dropped what an action was part of while it was done: no step of the trace is for it."""
        self._given_up.add(number)

    def leave(self, actor: str, free_us: int, now_us: int) -> None:
        """An actor does nothing more; it had been free before."""
        self._stays_us[actor] = now_us - free_us

    def has_left(self, actor: str) -> bool:
        """Whether an actor does nothing more."""
        return actor in self._stays_us

    def as_test(self, test: ConcreteTest, trace: Trace, programs: Mapping[str, Program]) -> ConcreteTest:
        """The test that is the same run.

        Args:
            test: the actions that were taken.
            trace: the trace of the agents, with each action's step, in any order that keeps each agent's own.
        """
        after = self._after(trace, programs)
        actions = list(test.actions)
        for action in self._begun:
            # As `Lanes` counts: the pause begins when the actor is free and the actions before this one are done.
            since_us = max([action.free_us, *(self._done_us[cause] for cause in after.get(action.number, ()))])
            values = {TURN: TURNS.simple_values()[0], PAUSE_S: (action.begun_us - since_us) / US_PER_S}
            place = action.number - 1
            actions[place] = replace(actions[place], parameters={**actions[place].parameters, **values})
        stays = {stay_of(actor): stay_us / US_PER_S for actor, stay_us in self._stays_us.items()}
        return replace(test, actions=tuple(actions), run={**test.run, TURN_WAIT_S: 0.0, **stays}, after=after)

    def _after(self, trace: Trace, programs: Mapping[str, Program]) -> dict[int, tuple[int, ...]]:
        """The order of the actions: the trace notes an action when it is done, the test when it begins."""
        lanes: dict[str, list[int]] = defaultdict(list)
        for action in self._begun:
            if action.number not in self._given_up:
                lanes[action.actor].append(action.number)
        pending = {actor: iter(lane) for actor, lane in lanes.items()}
        steps = [step.agent for step in trace if step.kind == "action" and step.agent in lanes]
        numbers = [next(pending[actor]) for actor in steps]
        after = {}
        for effect, before in causes(trace, programs, lanes).items():
            number = numbers[effect - 1]
            kept = sorted({numbers[cause - 1] for cause in before} & self._done_before[number])
            if kept:
                after[number] = tuple(kept)
        return dict(sorted(after.items()))
