"""Finds drift, for `hricdv update`: messages, values and transitions that only the code or the testbench has."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from pytest_hricdv.extra.draft.analysis import analyse
from pytest_hricdv.extra.draft.code.sources import DraftError
from pytest_hricdv.extra.draft.code_model import CodeModel, StateMachine
from pytest_hricdv.testbench import Testbench


@dataclass(frozen=True)
class Drift:
    """Something that the code has and the testbench lacks, or the other way round.

    Args:
        kind: "message": not on the bus of the testbench; "value" (a text or state) or "transition": not declared;
            "gone": declared, and no longer in the code.
        name: as the code calls it.
        location: its location in the code, such as `barista.py:12`; empty if it is gone.
        text: a sentence for people.
    """

    kind: str
    name: str
    location: str
    text: str

    @property
    def key(self) -> str:
        """Its name in `hri_known_drift`."""
        return f"{self.kind} {self.name}"


def models_of(code: Iterable[str], roots: Sequence[Path]) -> tuple[list[CodeModel], list[str]]:
    """Models of packages, without importing them; and what could not be read, a sentence each.

    Args:
        code: names of the packages under test.
        roots: folders from which they can be imported, looked at in this order.
    """
    models, problems = [], []
    for package in code:
        errors = []
        for root in roots:
            try:
                models.append(analyse(package, root))
                break
            except DraftError as error:
                errors.append(str(error))
        else:
            problems.append(errors[0] if errors else f"{package}: no folder to look for it")
    return models, problems


def drifts(models: Sequence[CodeModel], testbench: Testbench) -> list[Drift]:
    """Find parts of the code that the testbench lacks.

    Args:
        models: the models of the packages under test.
        testbench: the project's testbench.
    """
    by_key: dict[str, Drift] = {}
    for code in models:
        machine = next((machine for machine in code.machines if machine.field == testbench.state.name != ""), None)
        for drift in (
            *_messages(code, testbench),
            *_values(code, testbench, machine),
            *(_machine(machine, testbench) if machine is not None else ()),
        ):
            by_key.setdefault(drift.key, drift)
    return [*by_key.values()]


def _messages(code: CodeModel, testbench: Testbench) -> Iterator[Drift]:
    topics = testbench.vocabulary().messages
    for message in code.messages:
        # For other forms, the testbench has its own classes, whose names are unknown here.
        if message.form == "dataclass" and message.topic not in topics:
            verb = {"published": "publishes", "received": "receives", "both": "publishes and receives"}[
                message.direction
            ]
            text = f"the code {verb} {message.name}, which is not a message of the testbench"
            yield Drift("message", message.topic, str(message.location), text)


def _values(code: CodeModel, testbench: Testbench, machine: StateMachine | None) -> Iterator[Drift]:
    declared = testbench.vocabulary().values
    for message in code.messages:
        for field in message.fields:
            name = f"{message.topic}.{field.name}"
            if name not in declared or (machine is not None and machine.field == name):
                continue
            for value in field.values:
                if value.text not in declared[name]:
                    text = f"{name} can be {value.text!r}, which `values` of the testbench does not list"
                    yield Drift("value", f"{name}={value.text}", str(value.location), text)


def _machine(machine: StateMachine, testbench: Testbench) -> Iterator[Drift]:
    states = {state.name: state for state in machine.states}
    declared = testbench.vocabulary().values.get(testbench.state.name, ())
    for name, state in states.items():
        if declared and name not in declared:
            text = f"the code has state {name}, which `fields` does not list for {testbench.state.name}"
            yield Drift("value", f"{testbench.state.name}={name}", str(state.location), text)
    if not testbench.state.transitions or not machine.transitions:
        return
    moves = {(transition.source, transition.target): transition for transition in machine.transitions}
    for (source, target), transition in moves.items():
        if (source, target) not in testbench.state.transitions and source in states and target in states:
            text = f"the code goes from {source} to {target}, which is not a transition of the testbench"
            yield Drift("transition", f"{source}->{target}", str(transition.location), text)
    for source, target in testbench.state.transitions:
        if (source, target) not in moves:
            text = f"the testbench has a transition from {source} to {target}, which the code no longer has"
            yield Drift("gone", f"{source}->{target}", "", text)
