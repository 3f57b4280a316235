"""Literals as they leave their plan: instances of what a statement says, with variables replaced."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from pytest_hricdv.bdi.language.errors import EvaluationError
from pytest_hricdv.bdi.language.formulas import GoalTerm
from pytest_hricdv.bdi.language.terms import SOURCE_SELF, Structure, Variable, ground_structure, is_ground, sorted_terms
from pytest_hricdv.bdi.logic.substitution import Bindings, free_variables

from .intentions import Frame
from .values import Arguments, Value, arguments_of, value_of

if TYPE_CHECKING:
    from .agent import Agent

Maker = Callable[["Agent", Frame], Structure]
"""Makes the instance of a literal for a plan that is being executed."""


def maker_of(term: GoalTerm) -> Maker:
    """How to do :func:`instantiate` often: what is known of the literal beforehand is not looked at again."""
    if isinstance(term, Structure) and term.annots_tail is None and all(map(is_ground, term.annots)):
        value = value_of(term.args[0]) if len(term.args) == 1 else None
        if value is not None:
            return _with_argument(term, value)
        arguments = arguments_of(term)
        if arguments is not None:
            return _with_arguments(term, arguments)
    return lambda agent, frame: instantiate(agent, term, frame)


def _with_argument(literal: Structure, value: Value) -> Maker:
    """For the commonest literals with arguments: with one."""
    key = literal.key
    annots = literal.annots if literal.has_source() else sorted_terms((*literal.annots, SOURCE_SELF))

    def make(agent: Agent, frame: Frame) -> Structure:
        arg = value(frame.unifier)
        return instantiate(agent, literal, frame) if arg is None else ground_structure(key, (arg,), annots)

    return make


def _with_arguments(literal: Structure, arguments: Arguments) -> Maker:
    key = literal.key
    annots = literal.annots if literal.has_source() else sorted_terms((*literal.annots, SOURCE_SELF))

    def make(agent: Agent, frame: Frame) -> Structure:
        args = arguments(frame.unifier)
        return instantiate(agent, literal, frame) if args is None else ground_structure(key, args, annots)

    return make


def instantiate(agent: Agent, term: GoalTerm, frame: Frame) -> Structure:
    """A literal as it leaves its plan: bound, with a source, its free variables replaced by new ones.

    Raises:
        EvaluationError: it is no literal, or an expression in it has no value.
    """
    literal = literal_of(agent, term, frame.unifier)
    if not literal.ground:
        for variable in free_variables(literal):
            if not agent.run.is_fresh(variable):
                frame.unifier[variable] = agent.fresh()
        literal = literal_of(agent, literal, frame.unifier)
    return literal if literal.has_source() else literal.with_annotations((*literal.annots, SOURCE_SELF))


def literal_of(agent: Agent, term: GoalTerm, bindings: Bindings) -> Structure:
    """A literal with the variables replaced that are bound.

    Raises:
        EvaluationError: it is no literal, or an expression in it has no value.
    """
    literal = agent.value(term, bindings)
    if isinstance(literal, Variable):
        raise EvaluationError(f"variable {literal} has no value here", "body_var_without_value")
    if not isinstance(literal, Structure):
        raise EvaluationError(f"{term} is not a literal but {literal}")
    return literal
