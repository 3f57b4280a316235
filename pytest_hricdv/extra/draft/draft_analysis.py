"""`CodeReader`: the model of the code for a draft, from its source, programs that use it, and observations."""

from __future__ import annotations

import ast
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import TypeVar

from pytest_hricdv.extra.draft.analysis import analyse_sources, questions
from pytest_hricdv.extra.draft.code.attributes import AttributeStates
from pytest_hricdv.extra.draft.code.classes import FORMS, methods_of
from pytest_hricdv.extra.draft.code.created_objects import CreatedObjects
from pytest_hricdv.extra.draft.code.entry import EntryFinder, read_calls
from pytest_hricdv.extra.draft.code.flow import Flow, parameters_of
from pytest_hricdv.extra.draft.code.loading import find
from pytest_hricdv.extra.draft.code.messages import TAKES
from pytest_hricdv.extra.draft.code.ports import PortReader
from pytest_hricdv.extra.draft.code.stimuli import StimulusReader, is_reader
from pytest_hricdv.extra.draft.code_model import (
    OWN_MODULE,
    SCRIPT,
    CodeModel,
    Entry,
    FieldValue,
    Message,
    MessageField,
    Port,
)
from pytest_hricdv.extra.draft.observe.observations import Observations
from pytest_hricdv.extra.draft.observe.tracer import CALLBACK
from pytest_hricdv.extra.draft.observed_calls import absent_ports, messages_for_answers, messages_for_calls
from pytest_hricdv.extra.draft.observed_code import (
    best_entry,
    find_machines,
    function_at,
    keep_declared,
    methods_from_outside,
    period_of,
    with_observations,
    with_ports,
)
from pytest_hricdv.extra.draft.stand_ins.connections import READS

T = TypeVar("T")

DEPTH, BYTES = 30_000, 512 * 1024 * 1024
"""Most nested calls, and the stack (bytes) that they may take; memory is only taken where it is used."""

PERIOD_S, MAX_PERIOD_S = 0.1, 10.0
"""Period of a control loop without a declared one, and the longest that counts as one."""

MAX_ENTRIES = 8
"""Candidates that are looked at where the likeliest one gets nothing from outside."""

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
        self._used = read_calls(self._sources)
        self._flow = Flow(self._sources)
        self._stimuli = StimulusReader(self._sources, self._flow)
        self._inner = CreatedObjects(self._sources, self._flow)
        self._states = AttributeStates(self._sources, self._flow)
        self._entries = EntryFinder(self._sources, self._flow, self._used)
        self._chosen: Entry | None = None  # what was observed is of this one

    def model(self, seen: Observations | None = None, faulty: frozenset[str] = frozenset()) -> CodeModel:
        """The model that a draft is made of.

        Args:
            seen: what was observed.
            faulty: top-level names of libraries, and names of classes of the code with a dot before, that failed in
                first runs, so their objects get stand-ins; and entries ("module:Class") that no stimulus reaches.
        """
        return with_deep_stack(lambda: self._model(seen, faulty))

    def _model(self, seen: Observations | None, faulty: frozenset[str]) -> CodeModel:
        """The declarations of the code; observations add to them, and take nothing away."""
        model = analyse_sources(self._sources, self.name, self._asked, self._used, self._flow)
        if self._chosen is None or _key(self._chosen) in faulty:
            self._chosen = self._choose(model, seen, faulty) or self._chosen
        if self._chosen is None:
            return replace(model, messages=tuple(self._carry(model)))
        model = replace(model, entry=self._chosen)
        declared = self._with_entry(model, None, frozenset())
        if seen is None and not faulty:
            return declared
        made = keep_declared(declared, self._with_entry(model, seen, faulty))
        return replace(made, questions=tuple(questions(made)))

    def _choose(self, model: CodeModel, seen: Observations | None, faulty: frozenset[str]) -> Entry | None:
        """The entry that was asked for; else the likeliest one that gets something, or what programs made instead."""
        if self._asked or model.ros.endpoints:
            return model.entry
        every = dict.fromkeys((model.entry, *(entry for entry, _ in islice(self._entries.entries(), MAX_ENTRIES))))
        candidates = [entry for entry in every if entry is not None and _key(entry) not in faulty]
        made = (replace(model, entry=entry) for entry in candidates)
        chosen = next((model.entry for model in made if _has_inputs(self._with_entry(model, None, frozenset()))), None)
        if self._chosen is not None:
            return chosen
        chosen = chosen or next(iter(candidates), None)
        best = best_entry(seen, self._sources) if seen is not None else ""
        if seen is not None and best and (chosen is None or _key(chosen) not in (*seen.made, *seen.methods)):
            return self._entries.entry(best)
        return chosen

    def _with_entry(self, model: CodeModel, seen: Observations | None, faulty: frozenset[str]) -> CodeModel:
        """The model with the inputs and outputs of its entry."""
        assert model.entry is not None
        entry = replace(model.entry, ports=self._without_buses(model, model.entry.ports))
        inner = self._without_buses(model, self._inner.ports(entry, faulty))
        model = replace(model, entry=entry, inner=inner)
        entry = self._period(entry, seen) or entry
        if seen is not None:
            model = with_ports(replace(model, entry=entry), seen)
            inner_names = {port.name for port in model.inner}
            absent = absent_ports(seen, Path(model.root))
            more = (port for port in absent if port.name not in inner_names)
            model, entry = replace(model, inner=(*model.inner, *more)), model.entry or entry
        messages = list(_carry_by_ports(self._carry(model), (*entry.ports, *entry.method_ports, *model.inner)))
        items = list(self._items((*entry.ports, *entry.method_ports, *model.inner), messages))
        inputs = [*(message for message in messages if message.direction != "published"), *items]
        every = _unique((*messages, *items, *self._calls(entry, seen, bool(inputs))))
        model = replace(model, entry=entry, messages=every)
        model = self._with_state(model, seen)
        model = replace(model, messages=_unique((*model.messages, *self._calls_outside(model, seen))))
        model = with_observations(model, seen) if seen is not None else model
        return replace(model, questions=tuple(questions(model)))

    def _calls_outside(self, model: CodeModel, seen: Observations | None) -> Iterator[Message]:
        """The calls of the code to its ports."""
        entry = model.entry
        assert entry is not None
        is_typed = any(message.direction != "received" and message.form != "state" for message in model.messages)
        for port in (*entry.ports, *entry.method_ports, *model.inner):
            is_channel = port.role in ("queue", "publish", "bus") and port.direction != "received" and not is_typed
            if not port.default and (port.role in ("device", "connection") or is_channel):
                yield from messages_for_calls(port, entry, seen or Observations(), self._flow)
        yield from messages_for_answers(model.inputs, seen) if seen is not None else ()

    def _calls(self, entry: Entry, seen: Observations | None, has_inputs: bool) -> Iterator[Message]:
        """The calls that reach the entry."""
        called = methods_from_outside(seen, entry) if seen is not None else frozenset()
        callbacks = list(self._stimuli.callbacks(entry))
        yield from callbacks
        methods = list(self._stimuli.methods(entry, called)) if entry.is_class and not has_inputs else []
        if any(message.fields for message in callbacks):
            methods = [method for method in methods if method.channel in called or method.channel in self._used]
        handled = list(self._stimuli.handlers(entry)) if not (has_inputs or callbacks) else []
        open_ones = [method for method in methods if method.fields or not (handled and "unknown(" in method.delivery)]
        yield from open_ones
        yield from (message for message in handled if message.module != OWN_MODULE or not open_ones)
        observed = list(self._find_callbacks(entry, seen)) if seen is not None else []
        yield from (
            message for message in observed if message.fields or not (has_inputs or callbacks or methods or handled)
        )
        if not entry.is_class:
            yield from self._stimuli.functions()

    def _find_callbacks(self, entry: Entry, seen: Observations) -> Iterator[Message]:
        """Functions that the code passed to its ports while it ran, except those that the object passes itself."""
        scope = self._sources.class_named(entry.module, entry.name)
        own = {id(method.node) for method in methods_of(self._sources, scope).values()} if scope is not None else set()
        names = [key.removeprefix(CALLBACK) for key in seen.methods if key.startswith(CALLBACK)]
        for name in names:
            if any(other.startswith(f"{name} ") for other in names):
                continue  # the same with a text among the arguments is one of several
            function = function_at(self._sources, seen.methods[CALLBACK + name].location)
            if function is not None and id(function.node) not in own:
                yield from self._stimuli.callback(name, function)

    def _carry(self, model: CodeModel) -> Iterator[Message]:
        """Messages that the bus of a test carries; others are converted, or asked for."""
        for message in model.messages:
            module = self._sources.by_name.get(message.module)
            if module is None or not isinstance(module.scope.get(message.name), ast.ClassDef):
                continue  # a class in a class or function cannot be imported
            if message.form in FORMS:
                yield message
            elif message.direction != "published":
                yield self._stimuli.convert(replace(message, direction="received"))

    def _items(self, ports: tuple[Port, ...], messages: list[Message]) -> Iterator[Message]:
        typed = {message.channel for message in messages if message.direction != "published"}
        for port in ports if "" not in typed else ():
            if port.role == "queue" and port.direction != "published" and port.name.strip("_") not in typed:
                yield from self._stimuli.items(port, TAKES)
            elif port.role == "connection":
                yield from self._stimuli.items(port, READS)
            elif port.role in ("device", "bus"):
                names = tuple(
                    operation.name for operation in port.operations if operation.is_method and operation.result is None
                )
                yield from self._stimuli.items(replace(port, role="device"), names)
                yield from self._stimuli.messages_in_list(port)

    def _without_buses(self, model: CodeModel, ports: Iterable[Port]) -> tuple[Port, ...]:
        """The ports, whose buses are devices where no class of the code is a topic of them."""
        is_typed = any(message.form in FORMS and not message.channel for message in model.messages)
        return tuple(replace(port, role="device") if port.role == "bus" and not is_typed else port for port in ports)

    # --- control loops

    def _period(self, entry: Entry, seen: Observations | None) -> Entry | None:
        """The entry with the method that programs call again and again, where it has none that runs it."""
        scope = self._sources.class_named(entry.module, entry.name)
        if entry.method or scope is None:
            return None
        best: tuple[int, int, str] | None = None
        for name, method in methods_of(self._sources, scope).items():
            assert not isinstance(method.node, ast.ClassDef)
            parameters = parameters_of(method.node)[1:]
            times, period_s = period_of(seen, entry, name) if seen is not None else (0, 0.0)
            made = bool(times), len(list(ast.walk(method.node))), name
            is_step = not is_reader(method) and len(parameters) <= 1 and not name.startswith("_")
            if (times or self._used[name]) and period_s <= MAX_PERIOD_S and is_step:
                best = made if best is None else max(best, made)
        if best is None:
            return None
        parts = tuple(PortReader(self._sources, self._flow).ports(methods_of(self._sources, scope)[best[2]], skip=1))
        period_s = (period_of(seen, entry, best[2])[1] if seen is not None else 0.0) or PERIOD_S
        ports = tuple(replace(part, role="device") if part.operations  # what comes in is read off it
                      else replace(part, role="parameter", neutral=f"{period_s:g}", annotation="fixed")
                      for part in parts if not part.default)  # fmt: skip
        is_async = isinstance(methods_of(self._sources, scope)[best[2]].node, ast.AsyncFunctionDef)
        if is_async:
            return None
        return replace(entry, method=best[2], method_ports=ports, period_s=period_s)

    # --- states

    def _with_state(self, model: CodeModel, seen: Observations | None) -> CodeModel:
        """The model with the state of its object, if the code does not publish it."""
        entry = model.entry
        scope = self._sources.class_named(entry.module, entry.name) if entry is not None and not model.state else None
        if scope is None:
            return model
        declared = [*model.machines, *self._states.machines(scope)]
        observed = find_machines(seen, model) if seen is not None else ()
        machines = [*declared, *(machine for machine in observed if self._states.decides(scope, machine))]
        for number, machine in enumerate(machines):
            path = self._states.path(scope, machine)
            if path:
                values = tuple(FieldValue(state.name, state.location) for state in machine.states)
                field = MessageField("state", "str", "str", machine.location, values)
                message = Message("StateChanged", STATE_TOPIC, OWN_MODULE, "published", (field,), machine.location,
                                  (machine.location,), "state", path)  # fmt: skip
                others = [other for at, other in enumerate(machines) if at != number and other in model.machines]
                every = (replace(machine, field=f"{STATE_TOPIC}.state"), *others)
                return replace(model, machines=every, messages=(*model.messages, message))
        return replace(model, machines=(*model.machines, *self._states.enumerations()))


def _key(entry: Entry) -> str:
    return f"{entry.module}:{entry.name}"


def _has_inputs(model: CodeModel) -> bool:
    """Whether people can say something that is known, set what a device returns, or the code registers something."""
    entry = model.entry
    assert entry is not None
    if entry.name == SCRIPT:
        return True  # its loop reads what first runs will show
    operations = [
        operation for port in (*entry.ports, *entry.method_ports, *model.inner) for operation in port.operations
    ]
    is_open = any(operation.result is not None or operation.is_registration for operation in operations)
    return is_open or any(message.fields for message in model.inputs)


def _carry_by_ports(messages: Iterable[Message], ports: tuple[Port, ...]) -> Iterator[Message]:
    """Messages as the ports carry them, which are a bus, or queues; what has no way to the code is left out."""
    queues = {port.name.strip("_"): port.direction for port in ports if port.role == "queue"}
    is_bus = any(port.role == "bus" for port in ports)
    gets = [name for name, direction in queues.items() if direction != "published"]
    for message in messages:
        side = queues.get(message.channel, "")
        if message.direction == "both" and side in ("received", "published"):
            yield replace(message, direction="received" if side == "received" else "published")
        elif message.direction == "published" or is_bus or (gets and message.channel in ("", *gets)):
            yield message
        elif message.direction == "both":
            yield replace(message, direction="published")


def _unique(messages: tuple[Message, ...]) -> tuple[Message, ...]:
    """Each topic once: the first one has it."""
    topics: dict[str, Message] = {}
    for message in messages:
        topics.setdefault(message.topic, message)
    return tuple(topics.values())


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
