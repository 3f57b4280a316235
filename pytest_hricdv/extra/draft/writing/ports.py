"""The ports of a draft: what the code is handed in place of its hardware, its bus and its queues."""

from __future__ import annotations

import re

from pytest_hricdv.extra.draft.found.findings import Port
from pytest_hricdv.extra.draft.messages.speech import OPTIONS, PAYLOADS, SAYS, SENDERS, SUBSCRIBES
from pytest_hricdv.extra.draft.writing.calls import call_classes
from pytest_hricdv.extra.draft.writing.devices import device, has_unknowns, moving_classes
from pytest_hricdv.extra.draft.writing.drafted import Draft
from pytest_hricdv.extra.draft.writing.plain_classes import OWN_CLASSES, plain_classes
from pytest_hricdv.extra.draft.writing.templates.buses import (
    ASYNC_BUS,
    ASYNC_HEARING,
    CALLBACK_BUS,
    HEARING,
    INBOX_BUS,
    TOPIC_BUS,
)
from pytest_hricdv.extra.draft.writing.templates.connections import connection_class
from pytest_hricdv.extra.draft.writing.templates.queues import (
    ASYNC_QUEUES,
    OUTBOX,
    READLINE,
    SCRIPT,
    STREAM,
    SYNC_QUEUES,
)
from pytest_hricdv.extra.draft.writing.templates.stand_ins import ANYTHING, MISSING

_TYPED = "Inbox"
"""The class that a script's input comes from; a script without any has none."""


def _topic_bus(draft: Draft) -> str:
    """The bus of topics that are texts, with the names that the code calls its methods by."""
    bus = next(port for port in draft.ports if port.role == "bus")
    lines = []
    for name, side in (("HEARD", "heard"), ("SAID", "said")):
        by_topic: dict[str, list[str]] = {}
        for message in draft.topics:
            if message.direction == side:
                by_topic.setdefault(message.channel, []).append(message.name)
        pairs = [f"    {topic!r}: ({', '.join(kinds)},),".replace("'", '"') for topic, kinds in by_topic.items()]
        lines += ["", f"{name}: dict[str, tuple[type[Any], ...]] = {{", *pairs, "}"]
    for name, words in (("PAYLOADS", PAYLOADS), ("OPTIONS", OPTIONS), ("SENDERS", SENDERS)):
        listed = ", ".join(f'"{word}"' for word in words)
        lines += ["", f"{name} = ({listed})"]
    used = {operation.name: operation.is_async for operation in bus.operations}
    says, hears = _verbs(bus)
    text = TOPIC_BUS.replace("{async}", "async " if any(used.get(n) for n in ("publish", *says)) else "")
    is_async = any(used.get(name) for name in ("subscribe", *hears))
    text = text.replace("{async_subscribe}", "async " if is_async else "")
    text = text.replace("{hearing}", ASYNC_HEARING if draft.is_async else HEARING)
    return "\n".join(lines) + "\n" + text.replace("{aliases}", _aliases(draft))


def _verbs(bus: Port) -> tuple[list[str], list[str]]:
    """The other names by which the code says and hears."""
    names = [operation.name for operation in bus.operations]
    says = [name for name in names if name.strip("_") in SAYS and name != "publish"]
    return says, [name for name in names if name.strip("_") in SUBSCRIBES and name != "subscribe"]


def _aliases(draft: Draft) -> str:
    says, hears = _verbs(next(port for port in draft.ports if port.role == "bus"))
    lines = [f"    {name} = publish" for name in says] + [f"    {name} = subscribe" for name in hears]
    return "\n".join(["", *lines, ""]) if lines else ""


def ports(draft: Draft) -> str:
    """The module of the ports; without what this robot does not need."""
    parts = []
    roles = {port.role for port in draft.ports}
    arguments = [part for calling in draft.findings.calls for part in calling.arguments]
    is_unknown = any("Anything()" in part for part in arguments)
    if draft.missing or is_unknown or any(map(has_unknowns, draft.devices)):
        parts.append(ANYTHING)
    if draft.missing:
        parts.append(MISSING)
    how = bus_kind(draft)
    is_plain = any(message.form not in OWN_CLASSES for message in draft.plain)
    parts.append(plain_classes(draft))
    is_stream = bool(roles & {"reader", "writer"}) and is_plain
    is_called = bool(draft.findings.calls)
    if (
        "queue" in roles
        or is_stream
        or how in ("async", "inboxes", "topics")
        or draft.findings.channels
        or (is_called and draft.is_async)
    ):
        taken = "to_plain" if is_plain else "lambda message: message"
        parts.append((ASYNC_QUEUES if draft.is_async else SYNC_QUEUES).replace("{taken}", taken))
    if roles & {"queue", "publish"} or draft.findings.channels:
        parts.append(_outbox(draft))
    if is_stream:
        parts.append(_stream(draft))
    if any(channel.is_connection for channel in draft.findings.channels):
        parts.append(connection_class(draft.is_async))
    if how == "topics":
        parts.append(_topic_bus(draft))
    if how == "inboxes":
        parts.append(INBOX_BUS.replace("{aliases}", _aliases(draft)))
    if how in ("async", "callback"):
        parts.append(ASYNC_BUS if how == "async" else CALLBACK_BUS)
    parts.append(call_classes(draft))
    if draft.findings.script:
        parts.append(SCRIPT if draft.findings.channels else SCRIPT.replace(_TYPED, "Any"))
    parts.append(moving_classes(draft))
    parts += [device(draft, port) for port in draft.devices]
    body = "".join(parts)
    return _head(draft, body) + body


def _outbox(draft: Draft) -> str:
    """The class of what is said into; of messages without a class where there are some."""
    is_plain = any(message.form not in OWN_CLASSES for message in draft.plain)
    put = "async def put(self, message: Any) -> None:" if draft.is_async else (
        "def put(self, message: Any, *_: Any, **__: Any) -> None:"
    )  # fmt: skip
    message = "arguments[-1]"
    if is_plain:
        message += " if is_message(arguments[-1]) else of_plain(arguments[-1], self._kinds)"
    replaced = {
        "{kinds}": ", *kinds: type[Any]" if is_plain else "",
        "{remember}": "\n        self._kinds = kinds" if is_plain else "",
        "{message}": message,
        "{put}": put,
        "{value}": "message",
    }
    text = OUTBOX
    for mark, content in replaced.items():
        text = text.replace(mark, content)
    return text


def _stream(draft: Draft) -> str:
    """The class of a stream."""
    is_async = draft.is_async
    text = STREAM.replace("{async}", "async " if is_async else "")
    text = text.replace("{readline}", "return bytes(await self._inbox.get())" if is_async else READLINE)
    doc = "The next line; waits for it." if is_async else "The next line; empty where there is none for a while."
    return text.replace("{readline_doc}", doc)


def bus_kind(draft: Draft) -> str:
    """Which bus the code has: "", "own" (one like the plugin's), "async", "callback", "inboxes" or "topics"."""
    bus = next((port for port in draft.ports if port.role == "bus"), None)
    if bus is None:
        return ""
    if draft.topics:
        return "topics"
    if draft.is_async:
        return "async"
    subscribe = next((operation for operation in bus.operations if operation.name == "subscribe"), None)
    if subscribe is not None and len(subscribe.arguments) > 1:
        return "callback"
    names = {operation.name for operation in bus.operations}
    return "own" if names <= {"publish", "subscribe"} and not draft.findings.is_taken_from else "inboxes"


def _head(draft: Draft, body: str) -> str:
    lines = [
        '"""What the code is handed in the place of its hardware, its bus and its queues. Replace it part by part."""',
        "",
    ]
    lines += ["from __future__ import annotations", ""]
    modules = ("ast", "asyncio", "json", "queue", "sys", "warnings")
    lines += [f"import {name}" for name in modules if re.search(rf"(?<![\w.]){name}\.", body)]
    names = [name for name in ("Callable", "Iterator") if name in body]
    lines += [f"from collections.abc import {', '.join(names)}"] if names else []
    made = [name for name in ("dataclass", "fields") if re.search(rf"\b{name}(\(|$)|@{name}\(", body)]
    lines += [f"from dataclasses import {', '.join(made)}"] if made else []
    lines += ["from enum import Enum"] if re.search(r"Enum\)", body) else []
    lines += ["from functools import partial"] if "partial(" in body else []
    lines += ["from importlib import import_module"] if "import_module(" in body else []
    lines += ["from importlib.util import find_spec, module_from_spec"] if "module_from_spec(" in body else []
    lines += ["from pathlib import Path"] if "Path(" in body else []
    lines += ["from inspect import signature"] if "signature(" in body else []
    functions = [
        name
        for name in ("atan2", "cos", "degrees", "hypot", "inf", "remainder", "sin", "tau")
        if re.search(rf"\b{name}\b", body)
    ]
    lines += [f"from math import {', '.join(functions)}"] if "class Drive:" in body else []
    if draft.missing:
        lines += ["from importlib.abc import Loader, MetaPathFinder", "from importlib.machinery import ModuleSpec"]
    types = [name for name in ("FunctionType", "ModuleType", "SimpleNamespace") if re.search(rf"\b{name}\b", body)]
    lines += [f"from types import {', '.join(types)}"] if types else []
    typed = [name for name in ("Any", "ClassVar", "Literal", "Self") if re.search(rf"\b{name}\b", body)]
    lines += [f"from typing import {', '.join(typed)}"] if typed else []
    helpers = [name for name in ("is_message", "text_of") if f"{name}(" in body]
    own = [f"from pytest_hricdv.runtime import {', '.join(helpers)}"] if helpers else []
    if "Run" in body:
        own.append("from pytest_hricdv.testbench import Run")
    if "World" in body:
        own += ["", "from world import World"] if own else ["from world import World"]
    lines += [*([""] if own else []), *own]
    if draft.missing:
        names_ = ", ".join(f'"{name}"' for name in dict.fromkeys(name.partition(".")[0] for name in draft.missing))
        lines += ["", f"MISSING = ({names_},)"]
    if "REST_OF_RUN_S" in body:
        lines += ["", "REST_OF_RUN_S = 10_000.0  # longer than any run"]
    if "LOOKS_EACH_S" in body:
        lines += ["LOOKS_EACH_S = 0.02"]
    if "READ_S" in body:
        lines += ["READ_S = 1.0  # so long a line is waited for; TODO"]
    if "STATE_EACH_S" in body:
        lines += ["", "STATE_EACH_S = 0.1  # how often the state is looked at"]
    lines += ["", "MOVES_S = 1.0  # so long each motion takes; TODO"] if "MOVES_S" in body else []
    lines += (
        ["", "RECORDS_EACH_S = 0.5  # how often it is recorded where a base is"] if "RECORDS_EACH_S" in body else []
    )
    lines += ["", "TRACK_M = 0.3  # between the wheels; TODO"] if "TRACK_M" in body else []
    if re.search(r"\bSTEP_S", body):
        lines += [
            "",
            "STEP_S = 0.01  # so long each call of a device takes: a loop that only asks devices would not end",
        ]
    return "\n".join(lines) + "\n"
