"""The messages of a draft for which the code has no class, and what is drawn of each device."""

from __future__ import annotations

import json

from pytest_hricdv.extra.draft.code_model import OWN_MODULE, Message, MessageField
from pytest_hricdv.extra.draft.project.draft import Draft

_TYPES = {"bool": "bool", "float": "float", "str": "str"}

_DOCS = {
    "call": "Gets to the code as a call: {location}.",
    "item": "Gets to the code as {location} takes it.",
    "called": "The code has called this port: its method, and the first text among the arguments. {location}",
    "state": "The state of the robot has changed: {location}.",
}


def own_messages(draft: Draft) -> tuple[Message, ...]:
    """The messages that the draft defines."""
    return tuple(message for message in draft.messages if message.module == OWN_MODULE)


def messages_module(draft: Draft) -> str:
    """The module with these messages."""
    lines = [
        '"""Messages between people and the robot where its code has no classes for them."""',
        "",
        "from dataclasses import dataclass",
    ]
    for message in own_messages(draft):
        doc = _DOCS[message.form].format(location=message.location).replace("\\", "/").replace('"', "'")
        lines += ["", "", "@dataclass(frozen=True)", f"class {message.name}:", f'    """{doc}"""']
        lines += [""] if message.fields else []
        lines += [f"    {part.name}: {_type(part)}{_default(part)}" for part in message.fields]
    return "\n".join(lines) + "\n"


def _type(part: MessageField) -> str:
    return "int" if part.type == "int" else _TYPES.get(part.kind, "str")


def _default(part: MessageField) -> str:
    """Of texts, the values that the code knows, as a comment."""
    texts = ", ".join(json.dumps(value.text, ensure_ascii=True) for value in part.values[:6])
    return f"  # {texts}" if texts else ""
