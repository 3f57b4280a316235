"""The analysis of code for a draft: its declarations, how programs use it, and what was observed of it."""

from __future__ import annotations

import ast
import sys
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from pytest_hricdv.extra.draft.analysis import analyse_sources, questions
from pytest_hricdv.extra.draft.code.classes import form_of, methods_of
from pytest_hricdv.extra.draft.code.constants import Member, members
from pytest_hricdv.extra.draft.code.flow import Flow, parameters_of
from pytest_hricdv.extra.draft.code.loading import find
from pytest_hricdv.extra.draft.code.messages import TAKES
from pytest_hricdv.extra.draft.code.naming import camel, snake, word
from pytest_hricdv.extra.draft.code.ports import PortReader
from pytest_hricdv.extra.draft.code.sources import Scope, Sources, name_with_dots, resolve_import
from pytest_hricdv.extra.draft.code.stimuli import MESSAGE_FORMS, StimulusReader
from pytest_hricdv.extra.draft.code.usage import read_usage
from pytest_hricdv.extra.draft.code_model import (
    OWN_MODULE,
    CodeModel,
    Entry,
    FieldValue,
    Message,
    MessageField,
    Port,
    State,
    StateMachine,
)
from pytest_hricdv.extra.draft.observe.observations import Observations
from pytest_hricdv.extra.draft.observe.tracer import CALLBACK
from pytest_hricdv.extra.draft.observed_code import best_entry, methods_from_outside, period_of, with_observations

T = TypeVar("T")

DEPTH, BYTES = 30_000, 512 * 1024 * 1024
"""Calls in each other, and the stack that they may take; memory is only taken where it is used."""

PERIOD_S = 0.1
"""Of a control loop, where nothing says how often it runs."""

STATE_TOPIC = "state_changed"


class CodeReader:
    """Reads the code of a draft, once, and again with what was observed of it.

    Args:
        package: `PACKAGE` or `PACKAGE:FUNCTION`, as for `analyse`.
        start: the folder where it is looked for.

    Raises:
        DraftError: there is no such package or function.
    """

    def __init__(self, package: str, start: Path | None = None) -> None:
        self.name, _, self._asked = package.partition(":")
        with_deep_stack(lambda: self._read((start or Path.cwd()).resolve()))

    def _read(self, start: Path) -> None:
        self._sources = find(self.name, start)
        self._usage = read_usage(self._sources)
        self._flow = Flow(self._sources)
        self._stimuli = StimulusReader(self._sources, self._flow, self._usage)

    def model(self, seen: Observations | None = None, faulty: frozenset[str] = frozenset()) -> CodeModel:
        """What a draft is made of.

        Args:
            seen: what was observed.
            faulty: top-level names of libraries that failed in first runs: what is made from them gets a stand-in.
        """
        return with_deep_stack(lambda: self._model(seen, faulty))

    def _model(self, seen: Observations | None, faulty: frozenset[str]) -> CodeModel:
        entry_name = self._asked or (best_entry(seen, self._sources) if seen is not None else "")
        model = analyse_sources(self._sources, self.name, entry_name, self._usage)
        if model.entry is None:
            return replace(model, messages=tuple(self._carry(model)))
        missing = {p.text.split("`")[1] for p in model.problems if p.kind == "missing module" and "`" in p.text}
        entry = self._without_buses(model)
        model = replace(model, entry=entry, inner=tuple(self._inner(entry, frozenset(missing) | faulty)))
        messages = list(self._carry(model))
        received = [*self._stimuli.callbacks(_with_inner(entry, model.inner)), *self._items(entry, messages)]
        period = self._period(entry, seen)
        if period is not None:
            entry = period
        called = methods_from_outside(seen, entry) if seen is not None else frozenset()
        inputs = [message for message in messages if message.direction != "published"]
        inputs += [message for message in received if message.form == "item"]
        methods = list(self._stimuli.methods(entry, called)) if entry.is_class and not inputs else []
        if received:
            used = called | frozenset(self._usage.calls)
            methods = [message for message in methods if message.channel in used]
        every = _unique((*messages, *received, *methods))
        if seen is not None and all(message.direction == "published" for message in every):
            every = _unique((*every, *_callback_messages(seen, entry)))
        model = replace(model, entry=entry, messages=every)
        model = self._with_state(model, seen)
        model = replace(model, messages=_unique((*model.messages, *_device_messages(model))))
        model = with_observations(model, seen) if seen is not None else model
        return replace(model, questions=tuple(questions(model)))

    def _carry(self, model: CodeModel) -> Iterator[Message]:
        """Messages that the bus of a test carries; others are converted, or asked for."""
        for message in model.messages:
            module = self._sources.by_name.get(message.module)
            if module is None or not isinstance(module.scope.get(message.name), ast.ClassDef):
                continue  # a class in a class or function cannot be imported
            if message.form in MESSAGE_FORMS:
                yield message
            elif message.direction != "published":
                yield self._stimuli.convert(replace(message, direction="received"))

    def _items(self, entry: Entry, messages: list[Message]) -> Iterator[Message]:
        typed = {message.channel for message in messages if message.direction != "published"}
        for port in (*entry.ports, *entry.method_ports) if "" not in typed else ():
            if port.role == "queue" and port.direction != "published" and port.name.strip("_") not in typed:
                yield from self._stimuli.items(port, TAKES)
            elif port.role in ("device", "bus"):
                names = tuple(each.name for each in port.operations if each.is_method and each.result is None)
                yield from self._stimuli.items(replace(port, role="device"), names)

    def _without_buses(self, model: CodeModel) -> Entry:
        """The entry, whose buses are devices where no class of the code is a topic of them."""
        entry = model.entry
        assert entry is not None
        if any(message.form in MESSAGE_FORMS and not message.channel for message in model.messages):
            return entry
        made = tuple(replace(port, role="device") if port.role == "bus" else port for port in entry.ports)
        return replace(entry, ports=made)

    def _scope(self, entry: Entry) -> Scope | None:
        return next((scope for scope in self._sources.classes
                     if (scope.module.name, scope.node.name) == (entry.module, entry.name)), None)  # fmt: skip

    # --- objects that the code makes itself

    def _inner(self, entry: Entry, faulty: frozenset[str]) -> Iterator[Port]:
        scope = self._scope(entry)
        ports = PortReader(self._sources, self._flow)
        done: set[str] = set()
        for (owner, name), assigned in self._flow.attributes.items() if scope is not None else ():
            assert scope is not None
            for where, value in assigned if owner == id(scope.node) and name not in done else ():
                if not isinstance(value, ast.Call) or not name_with_dots(value.func):
                    continue
                top = resolve_import(where.module, value.func).partition(".")[0]
                own = self._sources.class_of(where.module, value.func)
                if top in faulty or (own is not None and _is_bus(self._sources, own)):
                    target = f"{where.module.name}:{name_with_dots(value.func)}"
                    done.add(name)
                    port = ports.attribute(scope, name, target, value)
                    yield port if port.role in ("bus", "device") else replace(port, role="device")

    # --- control loops

    def _period(self, entry: Entry, seen: Observations | None) -> Entry | None:
        """The entry with the method that programs call again and again, where it has none that runs it."""
        scope = self._scope(entry)
        if entry.method or scope is None:
            return None
        best: tuple[int, str] | None = None
        for name, method in methods_of(self._sources, scope).items():
            assert not isinstance(method.node, ast.ClassDef)
            parameters = parameters_of(method.node)[1:]
            times, period_s = period_of(seen, entry, name) if seen is not None else (0, 0.0)
            calls = self._usage.of(name)
            texts = [value for values in calls.values.values() for value in values if not _is_number(value)]
            repeated = times or (calls.in_loop if not texts else 0)
            if repeated and len(parameters) <= 1 and not name.startswith("_") and (best is None or repeated > best[0]):
                best = repeated, name
        if best is None:
            return None
        parts = tuple(PortReader(self._sources, self._flow).ports(methods_of(self._sources, scope)[best[1]], skip=1))
        numbers = [value for values in self._usage.of(best[1]).values.values() for value in values if _is_number(value)]
        seconds = period_of(seen, entry, best[1])[1] if seen is not None else 0.0
        period_s = next((float(number) for number in numbers if 0.001 <= number <= 10.0), seconds or PERIOD_S)
        given = tuple(replace(part, role="parameter", neutral=f"{period_s:g}", annotation="fixed")
                      for part in parts if not part.default or numbers)  # fmt: skip
        given = tuple(replace(part, default="") for part in given)
        is_async = isinstance(methods_of(self._sources, scope)[best[1]].node, ast.AsyncFunctionDef)
        if is_async:
            return None
        return replace(entry, method=best[1], method_ports=given, period_s=period_s)

    # --- states

    def _with_state(self, model: CodeModel, seen: Observations | None) -> CodeModel:
        """The model with the state of its object, if the code does not publish it."""
        entry = model.entry
        scope = self._scope(entry) if entry is not None and not model.state else None
        if scope is None:
            return model
        machines = [*model.machines, *self._attributes(scope)]
        for number, machine in enumerate(machines):
            path = self._path(scope, machine)
            if path:
                values = tuple(FieldValue(state.name, state.location) for state in machine.states)
                field = MessageField("state", "str", "str", machine.location, values)
                message = Message("StateChanged", STATE_TOPIC, OWN_MODULE, "published", (field,), machine.location,
                                  (machine.location,), "state", path)  # fmt: skip
                others = [each for at, each in enumerate(machines) if at != number and each in model.machines]
                found = (replace(machine, field=f"{STATE_TOPIC}.state"), *others)
                return replace(model, machines=found, messages=(*model.messages, message))
        return model

    def _path(self, scope: Scope, machine: StateMachine) -> str:
        """From the object to the attribute that holds the state of a machine; empty where there is no way."""
        owner, _, attribute = machine.held_in.rpartition(".")
        if not owner:
            return ""
        names = {scope.node.name, *(base.node.name for base in self._sources.base_classes(scope))}
        if owner in names:
            return attribute
        for (holder, name), assigned in self._flow.attributes.items():
            for where, value in assigned if holder == id(scope.node) else ():
                own = self._sources.class_of(where.module, value.func) if isinstance(value, ast.Call) else None
                if own is not None and own.node.name == owner:
                    return f"{name}.{attribute}"
        return ""

    def _attributes(self, scope: Scope) -> Iterator[StateMachine]:
        """Attributes that are only ever set to texts or members of one enumeration; those with most values first."""
        found = []
        for (owner, name), assigned in self._flow.attributes.items():
            if owner != id(scope.node):
                continue
            values = [value for where, expression in assigned
                      for value in self._flow.constants(expression, where.module, where)]  # fmt: skip
            texts = {value.text if isinstance(value, Member) else value: at for value, at in values
                     if isinstance(value, str | Member)}  # fmt: skip
            if len(texts) < 2 or len(texts) != len({str(value) for value, _ in values}) or "" in texts:
                continue
            enums = {value.enum for value, _ in values if isinstance(value, Member)}
            for own in self._sources.classes if len(enums) == 1 else ():
                if own.node.name in enums:
                    texts |= {member.text: own.module.location(at) for member, at in members(self._sources, own)
                              if member.text not in texts}  # fmt: skip
            states = tuple(State(text, at) for text, at in texts.items())
            location = next(iter(texts.values()))
            held = f"{scope.node.name}.{name}"
            found.append((bool(enums), len(states), StateMachine(name, "attribute", states, (), location, "", held)))
        yield from (machine for _, _, machine in sorted(found, key=lambda each: each[:2], reverse=True))


def _with_inner(entry: Entry, inner: tuple[Port, ...]) -> Entry:
    return replace(entry, ports=(*entry.ports, *inner))


def _is_bus(sources: Sources, scope: Scope) -> bool:
    return form_of(sources, scope) == "" and {"publish", "subscribe"} <= {*methods_of(sources, scope)}


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _callback_messages(seen: Observations, entry: Entry) -> Iterator[Message]:
    """Functions that the code handed to its ports while it ran, of which nobody knows with what they are called."""
    names = [key.removeprefix(CALLBACK) for key in seen.methods if key.startswith(CALLBACK)]
    for name in names:
        if any(other.startswith(f"{name} ") for other in names):
            continue  # the same with a text among the arguments is one of several
        count = int(seen.methods[CALLBACK + name].arguments["parameters"].high or 0)
        title = camel(word(name.rpartition(" ")[2].rpartition("/")[2].rpartition(".")[2]))
        arguments = "Neutral(), " * count
        how = f"CallbackCall({name!r}, lambda m: ({arguments.rstrip()}))" if count else f"CallbackCall({name!r})"
        yield Message(title, snake(title), OWN_MODULE, "received", (), entry.location, (entry.location,), "call",
                      "", how)  # fmt: skip


def _unique(messages: tuple[Message, ...]) -> tuple[Message, ...]:
    """Each topic once: the first one has it."""
    topics: dict[str, Message] = {}
    for message in messages:
        topics.setdefault(message.topic, message)
    return tuple(topics.values())


def _device_messages(model: CodeModel) -> Iterator[Message]:
    """A message for each device that tells what the code calls there."""
    entry = model.entry
    ports = (*entry.ports, *entry.method_ports, *model.inner) if entry is not None else ()
    typed = any(message.direction != "received" and message.form not in ("state", "called")
                for message in model.messages)  # fmt: skip
    for port in ports:
        is_channel = port.role in ("queue", "publish", "bus") and port.direction != "received" and not typed
        if port.default or (port.role != "device" and not is_channel):
            continue
        names = [each.name.strip("_") for each in port.operations
                 if each.is_method and each.result is None and not each.callbacks]  # fmt: skip
        names += [f"set_{each.name}" for each in port.operations if each.is_set and not each.callbacks]
        if is_channel:
            names = ["publish" if port.role == "bus" else "put"]
        if names:
            title = f"{camel(port.name.strip('_'))}Called"
            what = MessageField("what", "str", "str", port.location,
                                tuple(FieldValue(name, port.location) for name in dict.fromkeys(names)))  # fmt: skip
            text = MessageField("text", "str", "str", port.location)
            yield Message(title, snake(title), OWN_MODULE, "published", (what, text), port.location, (port.location,),
                          "called", port.name)  # fmt: skip


def with_deep_stack(function: Callable[[], T]) -> T:
    """The result of a function, called in a thread of its own; raises what it raises."""
    results: list[T] = []
    errors: list[BaseException] = []

    def call() -> None:
        try:
            results.append(function())
        except BaseException as error:
            errors.append(error)

    depth, size = sys.getrecursionlimit(), threading.stack_size(BYTES)
    sys.setrecursionlimit(DEPTH)
    try:
        thread = threading.Thread(target=call, name="draft")
        thread.start()
        thread.join()
    finally:
        threading.stack_size(size)
        sys.setrecursionlimit(depth)
    if errors:
        raise errors[0]
    return results[0]
