"""An agent that pauses before each act, and resumes when the run reports that the act has been done."""

from __future__ import annotations

from abc import ABC, abstractmethod

from pytest_hricdv.bdi import EvaluationError, Structure
from pytest_hricdv.bdi.agent.agent import Agent
from pytest_hricdv.bdi.agent.intentions import Event, Intention
from pytest_hricdv.bdi.language.syntax import ExternalAction, InternalActionCall
from pytest_hricdv.coupling.agent_names import CONTENT
from pytest_hricdv.coupling.coupled_run import CoupledRun
from pytest_hricdv.coupling.ready_acts import ReadyAct, ReadyActs
from pytest_hricdv.coupling.terms import comparable


class CoupledAgent(Agent, ABC):
    """An agent that pauses before acts; a subclass decides which. Takes the arguments of `Agent`."""

    run: CoupledRun

    def couple(self) -> None:
        """Prepare for a run."""
        self.ready_acts = ReadyActs()
        """Its ready acts, in the order in which they became ready."""
        self._released: Intention | None = None

    @abstractmethod
    def acts_of(self, intention: Intention, literal: Structure) -> tuple[int, ...] | None:
        """The declared acts that an intention is about to do; None if it need not pause before this one."""

    def execute(self, intention: Intention) -> None:
        """Execute the next statement of an intention, unless it has to pause before it."""
        if intention is self._released:
            self._released = None
        elif (literal := self._act_of(intention)) is not None:
            acts = self.acts_of(intention, literal)
            if acts is not None:
                self.stop_before(intention, str(literal), literal, acts)
                return
        super().execute(intention)

    def go_on_after(self, act: ReadyAct, succeeded: bool = True) -> None:
        """Resume after an act that it was ready for has been done."""
        self.ready_acts.remove(act)
        if act.literal is not None:
            self._released, self.run.succeeds = act.intention, succeeded
        # To the front: the statements after the act belong to the instant at which it was done.
        self.intentions.appendleft(act.intention)
        self.awake = True

    def all_intentions(self) -> list[tuple[Intention, Event | None]]:
        """All intentions, those before an act among them."""
        return super().all_intentions() + [(act.intention, None) for act in self.ready_acts]

    def remove_intention(self, intention: Intention) -> None:
        """Remove an intention, and the act that it is ready for."""
        super().remove_intention(intention)
        for act in [act for act in self.ready_acts if act.intention is intention]:
            self.ready_acts.remove(act)

    def stop_before(self, intention: Intention, text: str, literal: Structure | None, acts: tuple[int, ...]) -> None:
        """Pause an intention before an act."""
        # The innermost plan that has a label: plans without one are details of it.
        labelled = [means.plan.label for means in intention.stack if means.plan.has_label]
        plan = labelled[-1] if labelled else ""
        self.ready_acts.add(ReadyAct(text, literal, plan, self.run.now_s, intention, acts))

    def is_external(self, intention: Intention) -> bool:
        """Whether an intention is about to execute an external action."""
        means = intention.stack[-1]
        return not means.is_finished and isinstance(means.statement, ExternalAction)

    def _act_of(self, intention: Intention) -> Structure | None:
        """The message or external action that an intention is about to send or execute."""
        means = intention.stack[-1]
        if means.is_finished:
            return None
        statement = means.statement
        written: object = None
        if isinstance(statement, ExternalAction):
            written = statement.action
        elif isinstance(statement, InternalActionCall) and statement.call.name in CONTENT:
            written = statement.call.args[CONTENT[statement.call.name]]
        if written is None:
            return None
        try:
            literal = self.value(written, means.unifier)  # type: ignore[arg-type]
        except EvaluationError:
            return None  # executing it fails in the same way
        return comparable(literal) if isinstance(literal, Structure) else None
