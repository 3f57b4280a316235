"""Makes the mutants of the code under test: one for each change that an operator makes, in the order of the text.

`MutationRun` gets them from `all_mutants`, and draws some with `sample`. The operators are `robot_operators`, and some
of the library mutmut (https://github.com/boxed/mutmut). Its operators that replace a value by None, drop an
argument or misspell a string are left out: a type checker finds these bugs, or they end the run at once, so detecting
them says little about the tests.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from types import CodeType
from typing import Any

import libcst as cst
from mutmut.mutation import mutators

from pytest_hricdv.coverage.code_map import CodeMap
from pytest_hricdv.extra.mutation.robot_operators import ROBOT, Change, Changes
from pytest_hricdv.extra.mutation.source import Names, Source
from pytest_hricdv.generate.rng import digest, make_rng, shuffle


@dataclass(frozen=True)
class Mutant:
    """The code under test with one seeded bug.

    Args:
        id: a hash of the change, which stays the same if other code changes.
        file: name of the changed file.
        line: the first line that differs.
        statement: the number of the statement, as in the coverage bits.
        before: the changed lines, without indentation.
        after: what they became; empty if they were removed.
    """

    id: str
    file: str
    line: int
    statement: int
    operator: str
    before: str
    after: str
    text: str


def all_mutants(code: CodeMap) -> tuple[Mutant, ...]:
    """Every mutant of the code, in the order of files and lines.

    Changes that compile to the same code as the original, or as an earlier mutant, are left out: the simplest
    equivalent mutants (Papadakis et al.: Trivial Compiler Equivalence, ICSE 2015).
    """
    sources = [Source(file) for file in code.files]
    names = Names.of(sources)
    mutants: list[Mutant] = []
    first = 0
    for source in sources:
        numbers = {line: first + place for place, line in enumerate(source.file.statements)}
        mutants += _file_mutants(source, names, numbers)
        first += len(numbers)
    return tuple(mutants)


def sample(mutants: Sequence[Mutant], seed: int, most: int | None) -> list[Mutant]:
    """Up to `most` mutants in the order in which they are tried: shuffled, so that the first ones represent all."""
    return shuffle(make_rng("mutants", seed), mutants)[:most]


def _file_mutants(source: Source, names: Names, numbers: dict[int, int]) -> Iterator[Mutant]:
    path = str(source.file.path)
    seen = {_compile(source.file.text, path)}
    ids: Counter[str] = Counter()
    for operator, line, text in _mutant_texts(source, names):
        compiled = _compile(text, path)
        if compiled is None or compiled in seen:
            continue
        seen.add(compiled)
        place, before, after = _difference(source.file.text, text, line)
        key = digest("mutant", source.file.name, operator, before, after)[:8]
        ids[key] += 1
        name = key if ids[key] == 1 else f"{key}-{ids[key]}"
        yield Mutant(name, source.file.name, place, numbers[line], operator, before, after, text)


def _mutant_texts(source: Source, names: Names) -> Iterator[tuple[str, int, str]]:
    for node, line in source.places():
        for name, operator in OPERATORS.items():
            for old, new in operator(node, source, names):
                yield name, line, source.replace_node(old, new)


def _compile(text: str, path: str) -> object:
    """The compiled text without locations, for comparison; None if it is not valid Python."""
    try:
        return _content(compile(text, path, "exec", dont_inherit=True))
    except SyntaxError:  # the change is valid by itself, but not in its place, such as a break outside a loop
        return None


def _content(code: CodeType) -> object:
    constants = tuple(
        _content(constant) if isinstance(constant, CodeType) else (type(constant), repr(constant))
        for constant in code.co_consts
    )
    names = (code.co_name, code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars)
    return code.co_code, constants, names, code.co_flags, code.co_argcount, code.co_exceptiontable


def _difference(old: str, new: str, statement: int) -> tuple[int, str, str]:
    """The first differing line, and the differing lines of both texts; an addition is shown with its statement."""
    before, after = old.splitlines(), new.splitlines()
    start = _common(before, after)
    end = _common(before[start:][::-1], after[start:][::-1])
    gone, came = _text(before[start : len(before) - end]), _text(after[start : len(after) - end])
    if gone:
        return start + 1, gone, came
    first = before[statement - 1].strip()
    return statement, first, f"{first} ... {came}"


def _common(some: Sequence[str], others: Sequence[str]) -> int:
    count = 0
    for item, other in zip(some, others, strict=False):
        if item != other:
            break
        count += 1
    return count


def _text(lines: Sequence[str]) -> str:
    return "\n".join(line.strip() for line in lines)


def _by_library(
    kind: type[cst.CSTNode],
    operator: Callable[[Any], Iterable[cst.CSTNode]],
    node: cst.CSTNode,
    source: Source,
    names: Names,
) -> Iterator[Change]:
    if isinstance(node, kind):
        yield from ((node, changed) for changed in operator(node))


_LIBRARY: Mapping[str, tuple[type[cst.CSTNode], Callable[[Any], Iterable[cst.CSTNode]]]] = {
    "number plus one": (cst.BaseNumber, mutators.operator_number),
    "true or false": (cst.Name, mutators.operator_name),
    "another operator": (cst.CSTNode, mutators.operator_swap_op),
    "another keyword": (cst.CSTNode, mutators.operator_keywords),
    "negation removed": (cst.UnaryOperation, mutators.operator_remove_unary_ops),
    "set instead of added": (cst.AugAssign, mutators.operator_augmented_assignment),
    "choice fixed": (cst.IfExp, mutators.operator_if_exp),
    "case removed": (cst.Match, mutators.operator_match),
}

OPERATORS: Mapping[str, Changes] = {
    **ROBOT,
    **{name: partial(_by_library, kind, operator) for name, (kind, operator) in _LIBRARY.items()},
}
"""Name of an operator in reports -> the operator."""
