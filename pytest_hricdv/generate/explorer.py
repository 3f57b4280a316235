"""The explorer: runs the BDI agents with belief subsets, for the abstract tests they come up with."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache

from pytest_hricdv.bdi import BdiError, Environment, MultiAgentSystem, Structure
from pytest_hricdv.bdi.language.syntax_tree import children

from .abstract import Plans, command_from_action
from .beliefs import BeliefSpace
from .error import GenerateError, nearest
from .exploration import Exploration
from .model import Model

Content = tuple[tuple[str, ...], int]
EveryRun = tuple[tuple[str, ...], int, Iterable[str]]
"""An abstract test, the plans executed on the way as bits, and beliefs that lead to it."""

#: How the BDI engine says that a run was ended for its length.
_CUT_OFF = "round limit"


class Explorer:
    """Loads a model once and runs it with any number of belief subsets.

    A subset is a set: its percepts are always put in the space's order, so that it has one run, whatever order its
    beliefs were chosen in. Every run starts from the agents' initial beliefs and the model's own seed.

    Args:
        model: the agents.
        space: the beliefs they are steered with.

    Raises:
        GenerateError: the model cannot be loaded; it lacks an agent or a coverage plan; a belief of the space does not
            occur in the actor's program, so that choosing it could never change a test, and is not declared neutral.
    """

    def __init__(self, model: Model, space: BeliefSpace) -> None:
        self.model = model
        self.space = space
        self.runs = 0
        self.cut_off = 0
        # The plain environment: every external action succeeds, and changes nothing but the trace.
        self._stage = Environment()
        try:
            self._system = MultiAgentSystem.load(model.path, self._stage, engine="memo")
        except (BdiError, OSError) as error:
            raise GenerateError(f"BDI model {model.path}: {error}") from error
        self._check_agents()
        self.plan_labels: Plans = {agent: tuple(self._system.plan_labels(agent)) for agent in model.covered}
        self._coverage_plans = {agent: frozenset(labels) for agent, labels in self.plan_labels.items()}
        for agent, labels in self.plan_labels.items():
            if not labels:
                raise GenerateError(f"{model.path}: agent {agent!r} has no labelled plan; expected some to cover")
        self._check_beliefs()

    def _check_agents(self) -> None:
        for agent in (self.model.steering_agent, self.model.actor, *self.model.covered):
            if agent not in self._system.agents:
                known = nearest(agent, self._system.agents)
                raise GenerateError(f"{self.model.path}: no agent {agent!r} in this model{known}")

    def _check_beliefs(self) -> None:
        mentioned = _mentioned(self._system, self.model.actor)
        for belief in self.space.beliefs:
            if belief not in mentioned and belief not in self.space.neutral:
                raise GenerateError(
                    f"{self.model.path}: belief {belief!r} of the space occurs nowhere in agent {self.model.actor!r}, "
                    "so that choosing it could never change a test; expected it there, or among the neutral beliefs"
                    f"{nearest(belief, mentioned)}"
                )

    def explore(self, beliefs: Iterable[str]) -> Exploration:
        """Run the model with one subset.

        Raises:
            GenerateError: a belief is not of the space, the model fails, or an action has no text form.
        """
        subset = self.space.subset(beliefs)
        percepts = {self.model.steering_agent: [f"{self.model.chosen}({belief})" for belief in subset]}
        try:
            result = self._system.run(max_rounds=self.model.max_rounds, seed=self.model.seed, percepts=percepts)
        except BdiError as error:
            raise GenerateError(f"BDI model {self.model.path} with {' '.join(subset)}: {error}") from error
        self.runs += 1
        self.cut_off += result.ended == _CUT_OFF
        sequence = {agent: self._covered(agent, result.plans.get(agent, [])) for agent in self.model.covered}
        return Exploration(
            beliefs=subset,
            lines=tuple(_command(action) for agent, action in result.actions if agent == self.model.actor),
            plans={agent: frozenset(labels) for agent, labels in sequence.items()},
            sequence=sequence,
            rounds=result.rounds,
            ended=result.ended,
        )

    def every_run(self, plans: Sequence[tuple[str, str]]) -> list[EveryRun] | None:
        """Every run that there is with one start belief and any others.

        Args:
            plans: agents and labels that are of interest, by the number of their bit.

        Returns:
            For each the abstract test, the plans executed as bits, and beliefs that lead to it; None if the model does
            not allow for it.

        Raises:
            TooLargeError: there are too many runs.
            GenerateError: the model fails, or an action has no text form.
        """
        bits = {plan: 1 << place for place, plan in enumerate(plans)}

        def fold(actions: Sequence[tuple[str, str]], executed: Sequence[tuple[str, list[str]]]) -> Content:
            labels = {(agent, label) for agent, done in executed for label in done}
            lines = tuple(_command(action) for agent, action in actions if agent == self.model.actor)
            return lines, sum(bits.get(plan, 0) for plan in labels)

        model = self.model
        found: list[EveryRun] = []
        for start in self.space.start:
            given = {belief: belief == start for belief in self.space.start}
            try:
                runs = self._system.survey(
                    model.steering_agent, model.chosen, self.space.beliefs, given, fold, model.max_rounds, model.seed
                )
            except BdiError as error:
                raise GenerateError(f"BDI model {model.path}: {error}") from error
            if runs is None:
                return None
            found += [(lines, mask, {start, *atoms}) for (lines, mask), atoms in runs.items()]
        return found

    def _covered(self, agent: str, labels: list[str]) -> tuple[str, ...]:
        coverage = self._coverage_plans[agent]
        return tuple([label for label in labels if label in coverage])

    def notes(self) -> tuple[str, ...]:
        """What a suite should say of the runs so far: whether any had to be cut off, and so its test."""
        if not self.cut_off:
            return ()
        return (f"{self.cut_off} of {self.runs} runs of the model were cut off after {self.model.max_rounds} rounds",)


@lru_cache(maxsize=4096)
def _command(action: str) -> str:
    """As :func:`command_from_action`: a model has few actions, and they come in every run."""
    return command_from_action(action)


def _mentioned(system: MultiAgentSystem, actor: str) -> list[str]:
    """Every name that the actor's program uses for a belief, a goal, an action or an argument."""
    program = system.program(actor)
    names: dict[str, None] = {}
    pending: list[object] = [*program.beliefs, *program.goals, *program.plans]
    while pending:
        part = pending.pop()
        if isinstance(part, Structure):
            names[part.functor] = None
        pending.extend(children(part))
    return list(names)
