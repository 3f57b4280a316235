"""An agent that follows a run: it acts only when its act has been observed there."""

from __future__ import annotations

from collections.abc import Mapping

from pytest_hricdv.bdi import Structure
from pytest_hricdv.bdi.agent.intentions import Event, IntendedMeans, Intention
from pytest_hricdv.bdi.language.terms import SOURCE_SELF, Number
from pytest_hricdv.bdi.logic.unify import unify
from pytest_hricdv.coupling.coupled_agent import MS_PER_S, CoupledAgent, CoupledRun, ReadyAct
from pytest_hricdv.extra.oracle.oracle import Oracle


class FollowedAgent(CoupledAgent):
    """An agent that stops before each act that corresponds to an event; takes what an agent takes."""

    oracle: Oracle

    def follow(self, oracle: Oracle) -> None:
        """Prepare for following."""
        self.oracle = oracle
        self.couple()

    def react(self, event: Event) -> IntendedMeans | bool:
        """Select a plan, and stop before it if its beginning is an act."""
        reacted = super().react(event)
        if isinstance(reacted, IntendedMeans) and (acts := self.oracle.labels.get(reacted.plan.label)):
            self.stop_before(self.intentions.pop(), f"@{reacted.plan.label}", None, acts)
        return reacted

    def acts_of(self, intention: Intention, literal: Structure) -> tuple[int, ...] | None:
        """The declared acts that this one is; None if it is none."""
        does = self.oracle.actions
        acts = tuple(
            number
            for number in self.oracle.literals.get(literal.key, ())
            if (pattern := does[number].pattern) is not None and unify(pattern, literal, {}, [])
        )
        return acts or None


class ModelFollower:
    """The agent of one run.

    Args:
        oracle: what it follows.
        limits: belief -> the duration (s) that it believes in this run.
    """

    def __init__(self, oracle: Oracle, limits: Mapping[str, float]) -> None:
        self.run = CoupledRun()
        agent = oracle.agent.agent(self.run, FollowedAgent)
        assert isinstance(agent, FollowedAgent)
        agent.follow(oracle)
        self.agent = agent
        self.run.put([agent], oracle.others)
        for name, limit in limits.items():
            # Whole milliseconds: sums of them are exact, so that a limit is reached when it should be.
            self._set_belief(name, round(limit * MS_PER_S))
        self.run.settle()

    def _set_belief(self, name: str, value: float) -> None:
        beliefs = self.agent.beliefs
        for held in list(beliefs.bucket((False, name, 1)).values()):
            if isinstance(held, Structure):
                beliefs.remove(held)
        beliefs.add(Structure(name, (Number(value),), (SOURCE_SELF,)))

    @property
    def due_s(self) -> float:
        """When the agent's next wait is over (s); infinite if there is none."""
        return self.run.due_s

    def hear(self, literal: Structure, source: str, goal: bool) -> None:
        """Tell the agent something, or give it a goal, now."""
        self.run.tell(self.agent, literal, source, goal)

    def observe(self, act: ReadyAct, succeeded: bool = True) -> None:
        """An act for which the agent is ready has been observed: it goes on."""
        self.agent.go_on_after(act, succeeded)
        self.run.settle()

    def wait_until(self, time_s: float) -> None:
        """The clock has reached `time_s`, and no wait is over before it: the agent continues if one is over by now.

        Raises:
            BdiError: as `CoupledRun.wait_until`.
        """
        self.run.wait_until(time_s)
