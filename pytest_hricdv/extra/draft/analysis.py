"""The analysis of a package: all that is found in its source, without importing it."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from pytest_hricdv.extra.draft.found.findings import (
    Entry,
    Findings,
    FoundValue,
    Machine,
    Message,
    MessageField,
    Problem,
    State,
)
from pytest_hricdv.extra.draft.messages.calls import Called, CallFinder
from pytest_hricdv.extra.draft.messages.classes import MessageClasses
from pytest_hricdv.extra.draft.messages.plain import PlainFinder
from pytest_hricdv.extra.draft.messages.topics import TopicFinder
from pytest_hricdv.extra.draft.messages.typed import MessageFinder
from pytest_hricdv.extra.draft.questions import questions
from pytest_hricdv.extra.draft.reading.sources import Sources, find
from pytest_hricdv.extra.draft.reading.value_flow import ValueFlow
from pytest_hricdv.extra.draft.ros.nodes import ros_nodes
from pytest_hricdv.extra.draft.states.classes import KIND, class_machines
from pytest_hricdv.extra.draft.states.held import TOLD, looked_at_in_runs
from pytest_hricdv.extra.draft.states.libraries import LibraryMachines
from pytest_hricdv.extra.draft.states.modules import module_machines
from pytest_hricdv.extra.draft.states.tables import table_machines
from pytest_hricdv.extra.draft.states.variables import written_machines
from pytest_hricdv.extra.draft.surroundings.effects import problems
from pytest_hricdv.extra.draft.surroundings.entry import EntryFinder
from pytest_hricdv.extra.draft.surroundings.waits import constants, parameters, virtual, waits

SHARED = 0.5
"""Of the values of a field, so many have to be states for it to tell them (chosen)."""


def analyse(package: str, start: Path | None = None) -> Findings:
    """Read the code of a package, and find what a testbench needs. Nothing is imported or run.

    Args:
        package: `PACKAGE` or `PACKAGE:FUNCTION`: a name that can be imported from `start`, or a path.
        start: the folder where it is looked for; None for the working folder.

    Raises:
        DraftError: there is no such package or function, or no source.
    """
    name, _, entry_name = package.partition(":")
    sources = find(name, (start or Path.cwd()).resolve())
    findings = analysed(sources, name, entry_name)
    if not entry_name or findings.heard or findings.ros.endpoints:
        return findings
    hint = _other_entry(analysed(sources, name, ""), entry_name, findings.entry)
    return replace(findings, problems=(*findings.problems, *hint))


def _other_entry(other: Findings, named: str, entry: Entry | None) -> Iterator[Problem]:
    """Where the function that was named hears nothing: what the draft would take by itself, if that hears something."""
    if other.heard and other.entry is not None and other.entry != entry:
        heard = ", ".join(f"`{message.topic}`" for message in other.heard)
        yield Problem(
            "entry",
            f"nothing was found that `{named}` hears; `{other.entry.name}`, which it may make, hears {heard}: "
            f"to draft that, `--from {other.package}`",
            other.entry.place,
        )


def analysed(sources: Sources, name: str, entry_name: str) -> Findings:
    """The same of code that was read.

    Raises:
        DraftError: there is no such function.
    """
    flow = ValueFlow(sources)
    entry = EntryFinder(sources, flow).entry(entry_name)
    classes = MessageClasses(sources, flow)
    messages = MessageFinder(sources, flow, classes).messages()
    plain = PlainFinder(sources, flow, classes, entry).found()
    finder = TopicFinder(sources, flow, classes, entry)
    topics, open_topics = finder.found()
    messages += topics
    if any(message.direction != "heard" for message in messages):
        plain = plain.without("print")
    messages += tuple(message for message in plain.messages if _is_new(message, messages))
    machines = (
        *LibraryMachines(sources, flow).machines(),
        *table_machines(sources, flow),
        *written_machines(sources, flow),
        *class_machines(sources, flow),
    )
    called = Called(entry)
    if not any(message.direction != "said" for message in messages):
        called = CallFinder(sources, flow, entry).found(machines)
        entry = called.entry
        if any(message.direction == "said" and message.form != "failure" for message in called.messages):
            messages = tuple(message for message in messages if message.channel != "print")
            plain = plain.without("print")
        messages += called.messages
        if called.calls:  # what these put into a queue, the code is to take from there
            plain = plain.only(message.channel for message in messages)
    machines = _told(_unique((*machines, *module_machines(sources, flow))), messages, flow)
    machines, looked_at = looked_at_in_runs(machines, entry, flow)
    messages = (*_with_states(messages, machines), *looked_at)
    findings = Findings(
        package=name,
        root=str(sources.root),
        code=sources.code,
        messages=messages,
        machines=machines,
        waits=tuple(waits(sources, flow)),
        virtual=virtual(sources),
        constants=tuple(constants(sources)),
        parameters=tuple(parameters(sources, flow)),
        entry=entry,
        problems=(
            *(p for p in problems(sources, flow) if p.kind != "terminal" or not plain.has("input")),
            *finder.unseen(),
        ),
        ros=ros_nodes(sources, flow),
        channels=plain.channels,
        calls=called.calls,
        is_taken_from=finder.is_taken_from,
        script=_script(sources) if entry is None and not called.calls else "",
    )
    open_topics = () if called.calls or plain.channels else open_topics
    return replace(findings, questions=(*questions(findings), *plain.questions, *open_topics))


def _script(sources: Sources) -> str:
    """The first module whose top has a loop, also for its main program only: a program without a function."""
    for module in sources.modules:
        for statement in module.tree.body:
            body = statement.body if isinstance(statement, ast.If) else [statement]
            if any(isinstance(part, ast.While | ast.For) for part in body):
                return module.name
    return ""


def _is_new(message: Message, messages: Sequence[Message]) -> bool:
    """Whether a message without a class does not come where one of a class does."""
    return all(other.channel != message.channel for other in messages)


def _unique(machines: Sequence[Machine]) -> list[Machine]:
    """Without machines that a table or a library has already: a variable holds what stands there."""
    unique: list[Machine] = []
    for machine in machines:
        names = {state.name for state in machine.states}
        if machine.kind not in ("enum", "text") or all({s.name for s in other.states} != names for other in unique):
            unique.append(machine)
    return unique


def _told(machines: Sequence[Machine], messages: Sequence[Message], flow: ValueFlow) -> tuple[Machine, ...]:
    """The machines, with the field in which the code tells each; that one first, and made of it where there is none."""
    told: list[Machine] = []
    for machine in machines:
        names = {state.name for state in machine.states}
        fields = (
            (field, values)
            for field, values in _text_fields(messages)
            if names <= values or not field.startswith("print_")
        )  # what is printed seldom tells all
        field = next((field for field, values in fields if _is_of(values, names)), "")
        if machine.kind != KIND:  # what is said of an instance is a text of its own, as `self.state.label`
            field = field or _field_of(machine, messages, flow)
        told.append(replace(machine, told=field))
    if not any(machine.told for machine in told):
        for message in messages:
            for part in _state_fields(message):
                if message.direction != "heard" and len(part.values) > 1:
                    states = tuple(State(v.text, v.place, certainty=v.certainty) for v in part.values)
                    told.append(
                        Machine(message.name, "told", states, (), message.place, f"{message.topic}.{part.name}")
                    )
    return tuple(sorted(told, key=lambda machine: not machine.told))


def _state_fields(message: Message) -> list[MessageField]:
    """The texts of a message that are a state by their names; or the first one, where that of the message says so."""
    texts = [part for part in message.fields if part.kind == "str"]
    named = [part for part in texts if part.name in TOLD[:3]]
    return named or [part for part in texts[:1] if any(word in message.topic for word in TOLD[:4])]


def _field_of(machine: Machine, messages: Sequence[Message], flow: ValueFlow) -> str:
    """The field of a message that is made with the attribute that holds the state: `Status(self.state)`."""
    owner, _, attribute = machine.held.rpartition(":")[2].rpartition(".")
    if not attribute:
        return ""
    for message in messages:
        names = [part.name for part in message.fields]
        for call in flow.calls.get(message.name, ()) if message.direction != "heard" else ():
            pairs = [*zip(names, call.node.args, strict=False), *((k.arg, k.value) for k in call.node.keywords)]
            for name, value in pairs:
                written = ast.unparse(value).split(".")
                if attribute in written and len(written) > 1:
                    own = call.scope.owner.name if call.scope is not None and call.scope.owner is not None else ""
                    if own == owner or written[0] != "self" or len(written) > 2:
                        return f"{message.topic}.{name}"
    return ""


def _with_states(messages: Sequence[Message], machines: Sequence[Machine]) -> tuple[Message, ...]:
    """The messages, where one that tells states has all states as values."""
    states = {machine.told: machine.states for machine in reversed(machines) if machine.told and machine.kind != "told"}

    def with_states(message: Message, part: MessageField) -> MessageField:
        missing = states.get(f"{message.topic}.{part.name}", ())
        if part.by_type or not missing or part.kind not in ("str", ""):
            return part
        known = {value.text for value in part.values}
        more = tuple(FoundValue(state.name, state.place) for state in missing if state.name not in known)
        return replace(part, kind="str", values=part.values + more)

    return tuple(
        replace(message, fields=tuple(with_states(message, part) for part in message.fields)) for message in messages
    )


def _text_fields(messages: Sequence[Message]) -> Iterator[tuple[str, set[str]]]:
    for message in messages:
        if message.direction != "heard":
            for part in message.fields:
                if part.values:
                    yield f"{message.topic}.{part.name}", {value.text for value in part.values}


def _is_of(values: set[str], states: set[str]) -> bool:
    shared = len(values & states)
    return shared >= 2 and shared >= SHARED * max(len(values), len(states))
