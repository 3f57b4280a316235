"""Robots for which drafts are measured, each with what its code receives and has, written before a draft was made.

`robots/` has those that are part of this project; of the others, `truth.toml` names repository and commit.
"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from pytest_hricdv.extra.draft.project.draft import Draft

FOLDER = Path(__file__).parent


@dataclass(frozen=True)
class Element:
    """Something that is to be found.

    Args:
        kind: "message", "value" or "state".
        names: that it may have.
        is_example: whether it is a text that only a recording has: the code compares it with nothing.
    """

    kind: str
    names: frozenset[str]
    is_example: bool = False

    def is_like(self, other: Element) -> bool:
        """Whether both are the same thing: a kind of message may also be a value that tells kinds apart."""
        return (self.kind == "state") == (other.kind == "state") and bool(self.names & other.names)


@dataclass(frozen=True)
class Robot:
    """A code base.

    Args:
        key: its name in `truth.toml`.
        title: as the page calls it.
        asked: arguments of `init FOLDER`.
        truth: what is to be found.
        also: what is neither right nor wrong.
        record: the command that `hricdv record` is given; empty where there is none.
        sealed: whether nobody looks at its draft.
        repository: where it is cloned from, at this commit; empty for one of this project.
        commit: of the repository.
    """

    key: str
    title: str
    asked: tuple[str, str]
    truth: tuple[Element, ...]
    also: tuple[Element, ...] = ()
    record: tuple[str, ...] = ()
    sealed: bool = False
    repository: str = ""
    commit: str = ""


def robots(path: Path = FOLDER / "truth.toml") -> Iterator[Robot]:
    """All of them, in the order of the file."""
    for key, row in tomllib.loads(path.read_text(encoding="utf-8")).items():
        truth = [Element(kind, _names(text.split("|"))) for kind in ("message", "value", "state")
                 for text in row[f"{kind}s"]]  # fmt: skip
        also = [Element(kind, _names([text])) for text in row.get("also", ()) for kind in ("value", "state")]
        yield Robot(key, row["title"], tuple(row["asked"]), tuple(truth), tuple(also), tuple(row.get("record", ())),
                    row.get("sealed", False), row.get("repository", ""), row.get("commit", ""))  # fmt: skip


def elements(draft: Draft) -> list[Element]:
    """What a draft has found: what people can say or set, the texts in it, and states; also where it failed in runs."""
    draft = draft.whole
    found = [_message(thing.message.name, thing.message.topic, thing.message.channel) for thing in draft.inputs]
    called = {thing.message.channel for thing in draft.inputs}  # what is compared of their arguments are no messages
    answers = {(sensor.port, sensor.operation.key.partition(".")[0]) for sensor in draft.sensors
               if sensor.port not in called}  # fmt: skip
    found += [_message(f"{port}_{name}", name) for port, name in sorted(answers)]
    fields = [part for thing in draft.inputs for part in thing.message.fields]
    fields += [sensor.field for sensor in draft.sensors]
    if draft.ros is not None:
        incoming = ("subscription", "service", "action server")
        found = [_message(each.name) for each in draft.ros.declared if each.kind in incoming]
    values = [value for part in fields if part.kind == "str" for value in part.values]
    texts = {text: value.is_observed for value in reversed(values) for text in _texts(value.text) if text.strip()}
    found += [Element("value", _names([text, _last(text)]), is_example) for text, is_example in texts.items()]
    return found + [Element("state", _names([state])) for state in draft.states]


def counts(found: list[Element], robot: Robot) -> tuple[int, int, int, int]:
    """How many elements of the truth were found, how many there are; how many found ones are right, of how many."""
    judged = [each for each in found if any(map(each.is_like, robot.truth))
              or not (each.is_example or any(map(each.is_like, robot.also)))]  # fmt: skip
    right = sum(any(map(each.is_like, robot.truth)) for each in judged)
    return sum(any(map(each.is_like, found)) for each in robot.truth), len(robot.truth), right, len(judged)


def _texts(value: str) -> list[str]:
    """A text, or those in it, if it is JSON."""
    content = json.loads(value) if value.startswith("{") else value
    return [text for text in content.values() if isinstance(text, str)] if isinstance(content, dict) else [value]


def _message(*names: str) -> Element:
    return Element("message", _names([each for name in names for each in (name, _last(name))]))


def _last(name: str) -> str:
    return re.split(r"[ ./]", name)[-1]


def _names(texts: list[str]) -> frozenset[str]:
    """Texts without case and signs."""
    return frozenset(filter(None, (re.sub(r"[^a-z0-9:]+", "", text.lower()) for text in texts)))
