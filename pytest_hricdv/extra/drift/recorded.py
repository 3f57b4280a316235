"""What a recording of the real system has that a testbench lacks: texts, and numbers beyond its ranges."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from pytest_hricdv.extra.draft.ros.interfaces import interface_files
from pytest_hricdv.extra.drift.drifting import Drift
from pytest_hricdv.extra.recordings.observed import (
    MOST_TEXTS,
    Observed,
    Spread,
    Topic,
    is_infrastructure,
    key_of,
    observe,
)
from pytest_hricdv.extra.recordings.recording import read
from pytest_hricdv.testbench import Testbench


@dataclass(frozen=True)
class Seen:
    """What recordings show of a testbench's messages.

    Args:
        observed: topic by topic; None where nothing could be read.
        told: what is wrong with them, and what they do not share with the testbench, a sentence each.
    """

    observed: Observed | None
    told: tuple[str, ...]


def seen_in(recordings: Sequence[Path], testbench: Testbench) -> Seen:
    """Read recordings of what a testbench tests."""
    topics = {key_of(topic) for topic in testbench.vocabulary().messages}
    folders = [Path(folder) for folder in testbench.ros2.interfaces] if testbench.ros2 is not None else []
    made = read(recordings, lambda topic: key_of(topic) in topics, interface_files(folders))
    told = [text for recording in made for text in (*recording.problems, *recording.notes)]
    if not any(recording.parts for recording in made):
        return Seen(None, tuple(told))
    observed = observe(made)
    told += [f"{topic}: no message of it in {observed.source}" for topic in sorted(topics - observed.topics.keys())]
    for key, seen in observed.topics.items():
        if key not in topics and not is_infrastructure(seen.name):
            told.append(f"{seen.name}: {seen.count} in {observed.source}, and it is none of the testbench's messages")
        elif key in topics:
            told += [f"{key}: {text}" for text in _times(seen)]
    return Seen(observed, tuple(dict.fromkeys(told)))


def _times(seen: Topic) -> Iterator[str]:
    if seen.waits is not None and not seen.is_stream:
        yield f"after what was said before, {seen.waits.comment('s', 'waits')}"
    if seen.gaps is not None:
        yield f"between messages of it, {seen.gaps.comment('s', 'gaps')}"


def text_drifts(observed: Observed, testbench: Testbench) -> Iterator[Drift]:
    """Texts that were observed, and that `values` of the testbench does not have."""
    for name, declared in testbench.vocabulary().values.items():
        topic, _, field = name.partition(".")
        seen = observed.topics.get(key_of(topic))
        texts = Counter[str]() if seen is None else seen.texts.get(field, Counter())
        for text, count in texts.items() if len(texts) <= MOST_TEXTS else ():
            if text not in declared:
                sentence = f"{name} was {text!r} in {count} messages, which `values` of the testbench does not have"
                yield Drift("value", f"{name}={text}", observed.source, sentence)


@dataclass(frozen=True)
class Refinement:
    """A range of a conftest file, and what it is to be.

    Args:
        node: the call of `Range`.
        field: its key.
        ends: of the new range.
        spread: what was observed.
        is_whole: whether only whole numbers are possible.
    """

    node: ast.Call
    field: str
    ends: tuple[float, float]
    spread: Spread
    is_whole: bool


def refined(conftest: str, observed: Observed) -> tuple[str, list[str]]:
    """The text of a conftest file with ranges that hold what was observed; and what changes, a sentence each.

    A range in a line with `TODO` becomes the observed one; others are only widened: a testbench may want more than
    what people did.
    """
    try:
        tree = ast.parse(conftest)
    except SyntaxError:
        return conftest, []
    lines = conftest.splitlines(keepends=True)
    made = [made for made in _refinements(tree, observed, lines) if made is not None]
    by_line: dict[int, list[Refinement]] = {}
    for refinement in made:
        by_line.setdefault(refinement.node.lineno, []).append(refinement)
    told = []
    for number, refinements in by_line.items():
        lines[number - 1] = _line(lines[number - 1], refinements)
        for refinement in refinements:
            low, high = refinement.ends
            comment = refinement.spread.comment(whole=refinement.is_whole)
            before = ast.unparse(refinement.node)
            told.append(f"conftest.py:{number}: {refinement.field}: {before} to {low!r}, {high!r}: {comment}")
    return "".join(lines), told


def _refinements(tree: ast.Module, observed: Observed, lines: Sequence[str]) -> Iterator[Refinement | None]:
    for node in ast.walk(tree):
        for key, value in _entries(node):
            topic = _topic_of(key, observed)
            for field, sampler in _entries(value) if topic is not None else ():
                if topic is not None and field in topic.numbers and _is_range(sampler):
                    assert isinstance(sampler, ast.Call)
                    yield _refinement(sampler, field, topic.numbers[field], lines[sampler.lineno - 1])


def _entries(node: ast.AST) -> Iterator[tuple[str, ast.expr]]:
    """Keys that are texts, and values of a dict."""
    if isinstance(node, ast.Dict):
        for key, value in zip(node.keys, node.values, strict=True):
            if isinstance(key, ast.Constant) and isinstance(key.value, str):
                yield key.value, value


def _topic_of(command: str, observed: Observed) -> Topic | None:
    """The topic of what is said by a command: `order_tea`, `order tea in_time`."""
    own = key_of(command)
    names = [key for key in observed.topics if own == key or own.startswith(f"{key}_")]
    return observed.topics[max(names, key=len)] if names else None


def _is_range(node: ast.expr) -> bool:
    return (
        isinstance(node, ast.Call)
        and ast.unparse(node.func).rpartition(".")[2] == "Range"
        and len(node.args) >= 2
        and node.lineno == node.end_lineno
        and all(_number(argument) is not None for argument in node.args[:2])
    )


def _number(node: ast.expr) -> float | None:
    try:
        value = ast.literal_eval(node)
    except (ValueError, SyntaxError):
        return None
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else None


def _refinement(node: ast.Call, field: str, spread: Spread, line: str) -> Refinement | None:
    before = tuple(_number(argument) or 0.0 for argument in node.args[:2])
    is_whole = spread.is_whole and all(end == int(end) for end in before) and "TODO" not in line
    low, high = spread.ends(whole=is_whole)
    if "TODO" not in line:
        if before[0] <= spread.low and spread.high <= before[1]:
            return None
        low, high = (before[0] if before[0] <= spread.low else low), (before[1] if spread.high <= before[1] else high)
    return None if (low, high) == before else Refinement(node, field, (low, high), spread, is_whole)


def _line(line: str, refinements: Sequence[Refinement]) -> str:
    """The line with other ends of its ranges, and where they come from as its comment."""
    data = line.encode()
    for refinement in sorted(refinements, key=lambda made: made.node.col_offset, reverse=True):
        first, second = refinement.node.args[:2]
        text = f"{refinement.ends[0]!r}, {refinement.ends[1]!r}".encode()
        data = data[: first.col_offset] + text + data[second.end_col_offset :]
    code, mark, comment = data.decode().rstrip("\n").partition("  # ")
    several = len(refinements) > 1
    said = [f"{r.field}: {r.spread.comment(whole=r.is_whole)}" if several else r.spread.comment(whole=r.is_whole)
            for r in refinements]  # fmt: skip
    kept = [comment] if mark and "TODO" not in comment else []
    return f"{code}  # {'; '.join([*kept, *said])}\n"
