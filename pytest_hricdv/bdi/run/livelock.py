"""`LivelockDetector` detects that the agents of a run only repeat themselves, so that `SystemRun` ends the run.

`SystemRun` calls it after rounds without progress; `name_endless_plans` names the plans that had not ended.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping

from pytest_hricdv.bdi.agent.agent import Agent
from pytest_hricdv.bdi.agent.intentions import IntendedMeans, Intention
from pytest_hricdv.bdi.agent.plan_library import PlanLibrary
from pytest_hricdv.bdi.language.limits import check_text
from pytest_hricdv.bdi.language.syntax import Plan
from pytest_hricdv.bdi.language.syntax_tree import variables_of
from pytest_hricdv.bdi.language.terms import Variable

QUIET_ROUNDS = 40
"""Rounds without progress after which the mental states are compared in every round.

With 5 to 160, 200 runs of the case study's models and 70 programs of `tests/bdi` print, do and end the same; only the
number of rounds before a livelock is found changes with it.
"""


COMPARED = 100
"""Most events and intentions compared per round on average (chosen): if there are more, fewer rounds are compared."""


class LivelockDetector:
    """Detects that the agents only repeat themselves.

    When there has been no progress for a while and the mental states of all agents are what they were before,
    nothing will ever change, except by time.

    Args:
        agents: the agents of the run, which must not have begun.
    """

    def __init__(self, agents: Mapping[str, Agent]) -> None:
        self._agents = agents
        self.due = QUIET_ROUNDS
        """The round after which :meth:`repeats` has to be called next."""
        self._progress = 0
        self._most = 0
        """The greatest number of events and intentions so far."""
        self._fingerprints: set[int] = set()
        self._depths: dict[Intention, _Depth] = {}
        self._states: set[str] = set()
        self._progress_at_jump = -1
        self._states_at_jumps: set[str] = set()

    def repeats(self, rounds: int, progress: int) -> bool:
        """Whether the agents repeat themselves after a round, waits for time aside.

        Args:
            progress: the progress made so far.
        """
        if progress != self._progress:
            self._progress = progress
            self.due = rounds + QUIET_ROUNDS
            self._forget()
            return False
        held = sum(len(agent.events) + len(agent.intentions) for agent in self._agents.values())
        self.due = rounds + 1 + held // COMPARED
        if held > max(self._most, COMPARED):
            self._most = held  # who waits for more than ever is nowhere again; thousands are not compared for that
            return False
        # States are long for deep intentions: they are written out only when their fingerprint has come before.
        fingerprint = self._fingerprint()
        if fingerprint not in self._fingerprints:
            self._fingerprints.add(fingerprint)
            return False
        state = _mental_states(self._agents, None)
        if state in self._states:
            self._forget()
            return True
        self._states.add(state)
        return False

    def _fingerprint(self) -> int:
        """A number that is the same for equal mental states, and for few others."""
        known, self._depths = self._depths, {}

        def depth(agent: Agent, intention: Intention | None) -> int:
            if intention is None:
                return 0
            self._depths[intention] = counted = known.get(intention) or _Depth()
            return counted.of(agent, intention)

        parts: list[object] = []
        for agent in self._agents.values():
            parts.append((len(agent.events), len(agent.intentions)))
            parts += [(sign, literal if literal.ground else literal.key) for sign, literal, _ in agent.events]
            parts += [depth(agent, intention) for _, _, intention in agent.events]
            for intention in agent.intentions:
                top = intention.top
                about = top.literal if top.literal.ground else top.literal.key
                parts.append((depth(agent, intention), top.plan.label, top.pc, about))
        return hash(tuple(parts))

    def _forget(self) -> None:
        self._fingerprints.clear()
        self._states.clear()

    def repeats_after_jump(self, ticks: int, progress: int) -> bool:
        """Whether the agents only wait and check again, over and over, after a jump in time.

        Args:
            ticks: the virtual clock.
            progress: the progress made so far.
        """
        if progress != self._progress_at_jump:
            self._progress_at_jump = progress
            self._states_at_jumps.clear()
            return False
        state = _mental_states(self._agents, ticks)
        if state in self._states_at_jumps:
            return True
        self._states_at_jumps.add(state)
        return False


def name_endless_plans(agents: Iterable[Agent], *, repeats: bool) -> list[str]:
    """The plans that agents still execute when a run is ended, with their places.

    Args:
        repeats: whether they only repeat themselves: then plans of a goal that has others with a context are left
            out, because they wait for something that may come in another run.
    """
    plans = (
        (agent, plan) for agent in agents for plan in _current_plans(agent, conditional=not repeats) if not plan.builtin
    )
    return [*dict.fromkeys(f"{plan.location}: plan @{plan.label} of {agent.name}" for agent, plan in plans)]


def _current_plans(agent: Agent, *, conditional: bool) -> Iterator[Plan]:
    adding = (intention for sign, _, intention in agent.events if "!" not in sign)
    doing = (*agent.intentions, *(wait.intention for wait in agent.waits), *adding)
    current = (intention.top for intention in doing if intention is not None and intention.stack)
    goals = ((sign, literal, None) for sign, literal, _ in agent.events if "!" in sign)
    for sign, literal, plan in (*goals, *((means.sign, means.literal, means.plan) for means in current)):
        plans = agent.library.relevant(sign, literal.key)
        if plans and (conditional or all(other.context is None for other in plans)):
            yield plan or plans[0]


class _Depth:
    """How many plans of an intention can make a difference, counted only where its stack is another than before.

    What waits below a plan stays as it is while that plan is there: only the last one that is known may have gone on.
    """

    def __init__(self) -> None:
        self._library: PlanLibrary | None = None
        self._known: list[tuple[IntendedMeans, int]] = []
        """Plans that wait, each with the number of those up to it that count."""

    def of(self, agent: Agent, intention: Intention) -> int:
        """The number, with the plan that is executed."""
        stack, known = intention.stack, self._known
        if agent.library is not self._library:
            self._library = agent.library
            known.clear()
        while known and (len(known) >= len(stack) or known[-1][0] is not stack[len(known) - 1]):
            known.pop()
        del known[-1:]
        count = known[-1][1] if known else 0
        for place in range(len(known), len(stack) - 1):
            count += _counts(agent, stack[place])
            known.append((stack[place], count))
        return count + bool(stack)


def _relevant_plans(agent: Agent, intention: Intention | None) -> list[IntendedMeans]:
    """The plans of an intention but for those that can make no difference any more."""
    if intention is None or not intention.stack:
        return []
    *waiting, top = intention.stack
    return [means for means in waiting if _counts(agent, means)] + [top]


def _counts(agent: Agent, means: IntendedMeans) -> bool:
    return not (means.is_at_end and agent.library.forgets(means.plan))


def _mental_states(agents: Mapping[str, Agent], now: int | None) -> str:
    """All agents' events and intentions as text, with fresh variables numbered as they appear.

    Args:
        now: the virtual clock, if the waits are to be included.
    """
    parts = []
    for name, agent in agents.items():
        parts.append(f"{name}:")
        parts += [f"{sign}{literal}<{_intention_text(agent, waiting)}>" for sign, literal, waiting in agent.events]
        parts += [_intention_text(agent, intention) for intention in agent.intentions]
        if now is not None:
            for wait in agent.waits:
                left = None if wait.deadline is None else wait.deadline - now
                parts.append(f"{left} {_intention_text(agent, wait.intention)}")
            parts += [f"{goal.deadline - now} {goal.goal}" for goal in agent.deadlines]
    # Each iteration makes new variables: without numbers of their own, no state would ever come again.
    numbers: dict[str, int] = {}
    check_text(sum(map(len, parts)))
    return re.sub(r"\b_\d+\b", lambda match: f"_{numbers.setdefault(match[0], len(numbers))}", "\n".join(parts))


def _intention_text(agent: Agent, intention: Intention | None) -> str:
    return "|".join(
        f"{means.plan.label}@{means.pc}/{id(means.body)}/{len(means.blocks)} {means.sign}{means.literal} "
        f"{[f'{variable}={means.unifier[variable]}' for variable in _variables(means)]} "
        f"{[len(loop.solutions) for _, _, loop in means.blocks if loop is not None]}"
        f"{len(means.loop.solutions) if means.loop else ''}"
        for means in _relevant_plans(agent, intention)
    )


def _variables(means: IntendedMeans) -> list[Variable]:
    """The variables bound in a plan that its body could still use."""
    return sorted(variables_of(means.plan.body) & means.unifier.keys())
