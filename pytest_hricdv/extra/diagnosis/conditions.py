"""Learns the condition of a known violation: the shortest formula that holds at each violation, and only there.

`triage` calls `condition_for` and proposes the formula as the `when` of a `known_violations` entry. It is a conjunction
or disjunction of up to three atoms: the present value of a string or bool signal, a value it once had, a message that
came at any time before or lately, or a number on one side of a threshold. Monitors evaluate all atoms in one pass over
each run.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

from pytest_hricdv.monitor import Log, Vocabulary, parse_condition
from pytest_hricdv.monitor.logged import watch_all
from pytest_hricdv.monitor.node import IDENTIFIER

MAX_ATOMS = 3
"""Maximum number of atoms in a formula. Chosen: nobody would accept a longer one without reading the code."""

LATELY_S = (1, 5)
"""How far back "lately" reaches (s). Chosen: a reaction takes about a second, a motion a few."""

_MAX_TEXTS = 40
"""Maximum number of values of a string signal. Chosen: one with more values is not a state."""

_LONGEST_TEXT = 60
"""Maximum number of characters of a value. Chosen: a longer one is prose, which reports may truncate."""

_MAX_COMBINED = 60
"""How many of the best atoms are combined: 60 have 34,000 triples, which take a tenth of a second."""


@dataclass(frozen=True)
class RunMoment:
    """A moment of a run: node id of its test, and time (s)."""

    nodeid: str
    time_s: float


@dataclass(frozen=True)
class Examples:
    """Moments that a condition has to tell apart.

    Args:
        inside: moments at which it must hold.
        outside: moments at which it must not hold.
        elsewhere: moments at which it should not hold; of formulas of equal length, the one that holds at the fewest
            of them is taken.
    """

    inside: tuple[RunMoment, ...]
    outside: tuple[RunMoment, ...] = ()
    elsewhere: tuple[RunMoment, ...] = ()

    @property
    def all(self) -> tuple[RunMoment, ...]:
        """All moments in the order inside, outside, elsewhere."""
        return (*self.inside, *self.outside, *self.elsewhere)


@dataclass(frozen=True)
class LearnedCondition:
    """A formula that separates the examples, or comes closest to it.

    Args:
        text: the formula.
        wrong: the moments of `outside` at which it holds.
    """

    text: str
    wrong: tuple[RunMoment, ...] = ()


@dataclass(frozen=True)
class _Atom:
    """Part of a formula: its rank (the simplest first), its text, and the moments at which it holds, as bits."""

    rank: int
    text: str
    holds: int


def condition_for(examples: Examples, logs: Mapping[str, Log], vocabulary: Vocabulary) -> LearnedCondition | None:
    """The shortest condition that holds at all moments inside.

    Args:
        examples: moments, at least one of them inside.
        logs: node id -> log.
        vocabulary: names that the condition may use.

    Returns:
        The condition, which holds at as few moments outside as possible; None if none holds at all moments inside.
    """
    atoms = _atoms(examples, logs, vocabulary)
    best = min(_formulas(atoms, examples), default=None)
    if best is None:
        return None
    _, _, _, _, text = best
    holds = truths([text], examples.all, logs, vocabulary)[0]  # checked again, as a whole formula
    if not all(holds[: len(examples.inside)]):
        return None
    after = holds[len(examples.inside) :]
    return LearnedCondition(
        text, tuple(moment for moment, is_true in zip(examples.outside, after, strict=False) if is_true)
    )


def truths(
    texts: Sequence[str], moments: Sequence[RunMoment], logs: Mapping[str, Log], vocabulary: Vocabulary
) -> list[list[bool]]:
    """For each condition, whether it holds at each moment, as a monitor evaluates it."""
    parsed = [parse_condition(text, vocabulary) for text in texts]
    places: dict[str, list[int]] = {}
    for place, moment in enumerate(moments):
        places.setdefault(moment.nodeid, []).append(place)
    holds = [[False] * len(moments) for _ in texts]
    for nodeid, of_test in places.items():
        for number, watcher in enumerate(watch_all(parsed, logs[nodeid])):
            for place in of_test:
                holds[number][place] = watcher.holds_at(moments[place].time_s)
    return holds


def _atoms(examples: Examples, logs: Mapping[str, Log], vocabulary: Vocabulary) -> list[_Atom]:
    """The atoms; of several that hold at the same moments, only the simplest."""
    used = {moment.nodeid: logs[moment.nodeid] for moment in examples.all}
    texts = [*dict.fromkeys(_texts(used.values(), vocabulary)), *_thresholds(examples, used, vocabulary)]
    atoms: dict[int, _Atom] = {}
    for rank, (text, holds) in enumerate(zip(texts, truths(texts, examples.all, used, vocabulary), strict=True)):
        bits = sum(1 << place for place, is_true in enumerate(holds) if is_true)
        atoms.setdefault(bits, _Atom(rank, text, bits))
    return [*atoms.values()]


def _texts(logs: Iterable[Log], vocabulary: Vocabulary) -> Iterator[str]:
    """Atoms without numbers, the simplest first."""
    seen: dict[str, set[object]] = {}
    topics: set[str] = set()
    for log in logs:
        for name, (_, values) in log.signals.items():
            seen.setdefault(name, set()).update(values)
        for message in log.messages:
            topics.add(message.topic)
            for name, value in message.fields.items():
                seen.setdefault(f"{message.topic}.{name}", set()).add(value)
    kinds = _kinds(vocabulary)
    texts = [
        f'{name} == "{value}"'
        for name in sorted(seen)
        if kinds.get(name) is str and len(seen[name]) <= _MAX_TEXTS
        for value in sorted(map(str, seen[name]))
        if len(value) <= _LONGEST_TEXT and value.isprintable() and '"' not in value and "\\" not in value
    ]
    bools = [name for name in sorted(seen) if kinds.get(name) is bool]
    named = [topic for topic in sorted(topics) if all(map(IDENTIFIER.fullmatch, topic.split("/")))]
    yield from texts
    for name in bools:
        yield from (name, f"!{name}")
    for topic in named:
        yield from (f"once(on({topic}))", f"!once(on({topic}))")
    for inner in (*bools, *texts):
        yield from (f"once({inner})", f"!once({inner})")
    for topic in named:
        yield from (f"once[0:{span_s}](on({topic}))" for span_s in LATELY_S)


def _kinds(vocabulary: Vocabulary) -> dict[str, type]:
    fields = {
        f"{topic}.{name}": kind for topic, of_topic in vocabulary.messages.items() for name, kind in of_topic.items()
    }
    return {**vocabulary.signals, **fields}


def _thresholds(examples: Examples, logs: Mapping[str, Log], vocabulary: Vocabulary) -> Iterator[str]:
    """Comparisons of numbers that hold at all moments inside, but not at all others."""
    for name in sorted(name for name, kind in _kinds(vocabulary).items() if kind is float):
        inside = [_value(logs[moment.nodeid], name, moment.time_s) for moment in examples.inside]
        others = [
            _value(logs[moment.nodeid], name, moment.time_s) for moment in (*examples.outside, *examples.elsewhere)
        ]
        numbers = [value for value in inside if value is not None]
        if len(numbers) < len(inside):
            continue
        below = [value for value in others if value is not None and value < min(numbers)]
        above = [value for value in others if value is not None and value > max(numbers)]
        if below:
            yield f"{name} >= {_between(max(below), min(numbers))}"
        if above:
            yield f"{name} <= {_between(max(numbers), min(above))}"


def _value(log: Log, name: str, time_s: float) -> float | None:
    """The last value of a numeric signal or field at a time (s); None if it has none yet."""
    topic, _, field = name.partition(".")
    if field:
        heard = [message for message in log.messages if message.topic == topic and message.time_s <= time_s]
        return float(str(heard[-1].fields[field])) if heard else None
    times, values = log.signals.get(name, ((), ()))
    count = bisect_right(times, time_s)
    return float(values[count - 1]) if count else None


def _between(low: float, high: float) -> str:
    """A number with as few digits as possible between two others."""
    middle = (low + high) / 2
    for digits in range(1, 17):
        text = f"{middle:.{digits}g}"
        if low < float(text) < high:
            return repr(float(text))
    return repr(high)


_Formula = tuple[int, int, int, int, str]
"""Moments outside at which it holds, number of atoms, moments elsewhere, sum of ranks, text; the smallest is best."""


def _formulas(atoms: Sequence[_Atom], examples: Examples) -> Iterator[_Formula]:
    inside = (1 << len(examples.inside)) - 1
    outside = ((1 << len(examples.outside)) - 1) << len(examples.inside)

    def formula(parts: Sequence[_Atom], holds: int, sign: str) -> _Formula:
        elsewhere = (holds & ~inside & ~outside).bit_count()
        text = f" {sign} ".join(part.text for part in parts)
        return (holds & outside).bit_count(), len(parts), elsewhere, sum(part.rank for part in parts), text

    always = _best((atom for atom in atoms if atom.holds & inside == inside), outside)
    for size in range(1, MAX_ATOMS + 1):
        for parts in combinations(always, size):
            holds = -1
            for part in parts:
                holds &= part.holds
            yield formula(parts, holds, "&")
    never = _best((atom for atom in atoms if not atom.holds & outside and atom.holds & inside), ~inside)
    for size in range(2, MAX_ATOMS + 1):
        for parts in combinations(never, size):
            holds = 0
            for part in parts:
                holds |= part.holds
            if holds & inside == inside:
                yield formula(parts, holds, "|")


def _best(atoms: Iterable[_Atom], unwanted: int) -> list[_Atom]:
    """The atoms that hold at the fewest unwanted moments."""
    return sorted(atoms, key=lambda atom: ((atom.holds & unwanted).bit_count(), atom.rank))[:_MAX_COMBINED]
