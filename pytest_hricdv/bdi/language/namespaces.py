"""Namespaces of literals, as in Jason 3: `in_spaces` gives the names in a source their namespaces when it is parsed.

A literal of the namespace ``ns`` is a structure with the functor ``ns::p``; one of the default namespace has no prefix.
Literals without a prefix in the source belong to the namespace of their file or block, except for terms inside
literals, lists and comparisons. At run time, unification, substitution and the plan library use `split`,
`without_space` and `in_space`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

from pytest_hricdv.bdi.language.errors import EvaluationError, Location
from pytest_hricdv.bdi.language.plan_patterns import PlanPattern
from pytest_hricdv.bdi.language.syntax import Comparison, ExternalAction, Include, InitialGoal, Plan
from pytest_hricdv.bdi.language.syntax_tree import child_fields
from pytest_hricdv.bdi.language.terms import (
    VALUE_BY_RULE,
    AnnotatedVariable,
    Call,
    ListTerm,
    QualifiedLiteral,
    Structure,
    Term,
    Variable,
    is_name,
)


@dataclass(frozen=True, slots=True)
class NamespaceBlock:
    """``{ begin namespace(name, local) } ... { end }``; or ``{ namespace(name, local) }``, which only declares it."""

    name: str
    local: bool | None
    items: tuple[object, ...] | None
    location: Location


DEFAULT = "default"
"""The default namespace."""
THIS = "this_ns"
"""How a source refers to its own namespace."""
LOCAL = "#"
"""Prefix of the names of local namespaces; no source can contain it."""
_KEYWORDS = frozenset(
    {("true", 0), ("false", 0), ("source", 1), ("atomic", 0), ("breakpoint", 0), ("all_unifs", 0), ("self", 0)}
    | {("percept", 0), ("tell", 0), ("default", 0), ("this_ns", 0), ("kqml_received", 4), ("state", 1)}
)
"""Predicates that are always in the default namespace."""


@lru_cache(maxsize=4096)  # more than the predicates of a model
def split(functor: str) -> tuple[str, str]:
    """Split a functor into its namespace and its name there."""
    space, separator, name = functor.partition("::")
    return (space, name) if separator and not functor.startswith("'") else (DEFAULT, functor)


def without_space(literal: Structure) -> tuple[Structure, Structure]:
    """The namespace of a literal, and the literal without its prefix."""
    space, name = split(literal.functor)
    if space == DEFAULT:
        return Structure(DEFAULT), literal
    return Structure(space), Structure(name, literal.args, literal.annots, literal.negated, literal.annots_tail)


def in_space(space: Term, literal: Term, written: QualifiedLiteral) -> Term:
    """Put a literal into a namespace; other terms, and literals that have one, are returned unchanged.

    Args:
        space: the namespace: a name, or a variable without a value.
        written: the literal as written in the source, for the error.

    Raises:
        EvaluationError: the namespace is not a name.
    """
    if not isinstance(literal, (Structure, Variable, AnnotatedVariable)):
        return literal
    if isinstance(space, Variable):
        return QualifiedLiteral(space, literal)
    if not isinstance(space, Structure) or not is_name(space):
        raise EvaluationError(f"{space} is not the name of a namespace, in {written}")
    if not isinstance(literal, Structure):
        return QualifiedLiteral(space, literal)
    if space.functor == DEFAULT or split(literal.functor)[0] != DEFAULT:
        return literal
    functor = f"{space.functor}::{literal.functor}"
    return Structure(functor, literal.args, literal.annots, literal.negated, literal.annots_tail)


def in_spaces(items: list[Any], space: str, numbers: Iterator[int]) -> list[Any]:
    """Resolve the namespaces of the parts of a source.

    Args:
        items: the parts as written.
        space: the namespace of the file.
        numbers: numbers for the names of local namespaces.
    """
    return list(_in_blocks(items, _Scope(space, {}), numbers))


@dataclass(frozen=True, slots=True)
class _Scope:
    """The namespace of a block of a file.

    Args:
        names: name in the file -> local namespace, of those declared so far.
    """

    space: str
    names: dict[str, str]

    def functor(self, written: str, arity: int, qualify: bool) -> str:
        """The qualified form of a functor."""
        space, separator, name = written.partition("::")
        if written.startswith("'") or not separator:
            if not qualify or (written, arity) in _KEYWORDS:
                return written
            space, name = self.space, written
        elif space in ("", THIS):
            space = self.space
        space = self.names.get(space, space)
        return name if space == DEFAULT else f"{space}::{name}"


def _in_blocks(items: list[Any], scope: _Scope, numbers: Iterator[int]) -> Iterator[Any]:
    for item in items:
        if isinstance(item, NamespaceBlock):
            if item.local and item.name not in scope.names:
                scope.names[item.name] = f"{LOCAL}{next(numbers)}{item.name}"
            elif item.local is False:
                scope.names.pop(item.name, None)
            yield from _in_blocks(list(item.items or ()), _Scope(item.name, scope.names), numbers)
        elif isinstance(item, Include):
            yield item if item.space else replace(item, space=scope.names.get(scope.space, scope.space))
        elif isinstance(item, InitialGoal):
            yield InitialGoal(resolve(item.literal, scope, True))
        elif isinstance(item, PlanPattern):
            yield PlanPattern(resolve(item.plans, scope, True), resolve(item.beliefs, scope, True))
        elif item is not None:
            yield resolve(item, scope, True)


def resolve(part: Any, scope: _Scope, qualify: bool) -> Any:
    """Resolve the namespaces in a part of a source; ``qualify``: whether its literal is in the block's namespace."""
    if isinstance(part, tuple):
        return tuple(resolve(item, scope, qualify) for item in part)
    if isinstance(part, Structure):
        return _literal(part, scope, qualify)
    if isinstance(part, (Variable, AnnotatedVariable)):
        return _variable(part, scope, qualify)
    if isinstance(part, QualifiedLiteral):
        space, literal = part.space, resolve(part.literal, scope, False)
        if isinstance(space, Structure):
            space = Structure(scope.functor(f"{space.functor}::", 0, True).removesuffix("::") or DEFAULT)
        return QualifiedLiteral(space, literal)
    if isinstance(part, ListTerm):
        return ListTerm(resolve(part.items, scope, False), resolve(part.tail, scope, False))
    if isinstance(part, ExternalAction) and isinstance(part.action, Variable):
        return part  # a body
    if isinstance(part, Call):
        return replace(part, args=resolve(part.args, scope, part.name == VALUE_BY_RULE))
    fields = child_fields(part)
    if not fields:
        return part
    inner = qualify and not isinstance(part, Comparison)
    changed = {name: resolve(getattr(part, name), scope, inner) for name in fields}
    if isinstance(part, Plan) and part.has_label:
        changed["label"] = scope.functor(part.label, 0, qualify)
    return replace(part, **changed)


def _literal(literal: Structure, scope: _Scope, qualify: bool) -> Structure:
    functor = scope.functor(literal.functor, len(literal.args), qualify)
    if literal.functor == THIS and not literal.args:
        functor = scope.names.get(scope.space, scope.space)
    args, annots = (resolve(part, scope, False) for part in (literal.args, literal.annots))
    return Structure(functor, args, (), literal.negated).with_annotations(annots, literal.annots_tail)


def _variable(variable: Variable | AnnotatedVariable, scope: _Scope, qualify: bool) -> Term:
    if isinstance(variable, AnnotatedVariable):
        annots = resolve(variable.annots, scope, False)
        variable = AnnotatedVariable(variable.variable, annots, variable.annots_tail, variable.negated)
    if not qualify or scope.space == DEFAULT:
        return variable
    return QualifiedLiteral(Structure(scope.names.get(scope.space, scope.space)), variable)
