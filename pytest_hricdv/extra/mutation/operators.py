"""All mutation operators: those for robots, and those of the library mutmut (https://github.com/boxed/mutmut).

Not all of the library's are used. Those that put None where something else is expected, leave out an argument or
misspell a text make faults that a type checker finds or that end the run at once: a high share of them noticed says
nothing of the tests.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from typing import Any

import libcst as cst
from mutmut.mutation import mutators

from pytest_hricdv.extra.mutation.names import Names
from pytest_hricdv.extra.mutation.robot_operators import ROBOT, Change, Changes
from pytest_hricdv.extra.mutation.source import Source


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
"""What is shown of an operator -> the operator."""
