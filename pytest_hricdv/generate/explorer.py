"""The explorer: runs the BDI agents with belief subsets, for the abstract tests they come up with."""

from __future__ import annotations

from collections.abc import Iterable

from pytest_hricdv.bdi import BdiError, Environment, MultiAgentSystem, Structure

from .abstract import Plans, command_from_action
from .beliefs import BeliefSpace
from .error import GenerateError
from .exploration import Exploration
from .model import Model


class _Stage(Environment):
    """The world of an exploration: every external action succeeds, and changes nothing but the trace."""

    def execute(self, agent: str, action: Structure) -> bool:
        """Let the action succeed."""
        return True


class Explorer:
    """Loads a model once and runs it with any number of belief subsets.

    A subset is a set: its percepts are always put in the space's order, so that it has one run, whatever order its
    beliefs were chosen in. Every run starts from the agents' initial beliefs and the model's own seed.

    Args:
        model: the agents.
        space: the beliefs they are steered with.

    Raises:
        GenerateError: the model cannot be loaded; it lacks an agent or a coverage plan; a belief of the space does not
            occur in the actor's program, so that choosing it could never change a test.
    """

    def __init__(self, model: Model, space: BeliefSpace) -> None:
        self.model = model
        self.space = space
        self.runs = 0
        self._stage = _Stage()
        try:
            self._system = MultiAgentSystem.load(model.path, self._stage)
        except (BdiError, OSError) as error:
            raise GenerateError(f"BDI model {model.path}: {error}") from error
        self._check_agents()
        self.plan_labels: Plans = {agent: tuple(self._system.plan_labels(agent)) for agent in model.covered}
        for agent, labels in self.plan_labels.items():
            if not labels:
                raise GenerateError(f"{model.path}: agent {agent!r} has no labelled plan; expected some to cover")
        self._check_beliefs()

    def explore(self, beliefs: Iterable[str]) -> Exploration:
        """Run the model with one subset.

        Raises:
            GenerateError: a belief is not of the space, the model fails, or an action has no text form.
        """
        subset = self.space.subset(beliefs)
        percepts = [f"{self.model.chosen}({belief})" for belief in subset]
        for percept in percepts:
            self._stage.add_percept(self.model.steering_agent, percept)
        try:
            result = self._system.run(max_rounds=self.model.max_rounds, seed=self.model.seed)
        except BdiError as error:
            raise GenerateError(f"BDI model {self.model.path} with {' '.join(subset)}: {error}") from error
        finally:
            for percept in percepts:
                self._stage.remove_percept(self.model.steering_agent, percept)
        self.runs += 1
        sequence = {agent: tuple(result.plans.get(agent, ())) for agent in self.model.covered}
        return Exploration(
            beliefs=subset,
            lines=tuple(command_from_action(action) for agent, action in result.actions if agent == self.model.actor),
            plans={agent: frozenset(labels) for agent, labels in sequence.items()},
            sequence=sequence,
            rounds=result.rounds,
            ended=str(result.ended),
        )
