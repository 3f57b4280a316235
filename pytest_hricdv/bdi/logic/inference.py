"""Inference from an agent's beliefs: resolution with backtracking, newest beliefs first.

`first` and `solve` answer the contexts and conditions of plans. They keep their own stack of choices, so that deep
rules cannot exhaust Python's, and stop runaway recursion with an error that names the rule.
"""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv.bdi.language.errors import BdiError
from pytest_hricdv.bdi.language.limits import WORK, LimitError, too_much_work
from pytest_hricdv.bdi.language.syntax import And, Comparison, Formula, Not, Rule
from pytest_hricdv.bdi.language.terms import Structure, Variable, is_ground
from pytest_hricdv.bdi.logic.alternatives import Goals, Reasoner, alternatives
from pytest_hricdv.bdi.logic.substitution import Bindings, substitute
from pytest_hricdv.bdi.logic.unify import Trail, compare, undo, unify

MAX_CHOICES = 50_000
"""Open choices of one query: a recursion over a list has one for each item, and a rule that only calls itself reaches
this in two seconds."""
MAX_NESTED_QUERIES = 60
"""Queries within queries: Python's stack of 1,000 frames is exhausted at 325 through ``not``, at 121 through
``.findall``."""


def first(agent: Reasoner, formula: Formula, bindings: Bindings) -> Bindings | None:
    """The first solution of a formula, as bindings that extend the given ones; None if there is none."""
    kind = type(formula)
    # Most contexts are propositional: those need no machine.
    if kind is Structure:
        answer = _ground_answer(agent, formula)  # type: ignore[arg-type]
        if answer is not None:
            return bindings if answer else None
        only = _only_candidate(agent, formula)  # type: ignore[arg-type]
        if only is not None:
            return _extend(formula, only, bindings)  # type: ignore[arg-type]
    elif isinstance(formula, Not):
        return bindings if first(agent, formula.part, bindings) is None else None
    elif isinstance(formula, And):
        return _first_of_all(agent, formula, bindings)
    return _first_by_machine(agent, formula, formula, bindings)


def _first_by_machine(agent: Reasoner, formula: Formula, rest: Formula, bindings: Bindings) -> Bindings | None:
    """The first solution of the rest of a formula, whatever it is made of."""
    agent.enter_query(formula)
    try:
        return next(solve(agent, rest, bindings), None)
    finally:
        agent.leave_query()


def _first_of_all(agent: Reasoner, formula: And, bindings: Bindings) -> Bindings | None:
    """The first solution of a conjunction; parts with a single answer are decided without the machine."""
    parts = formula.parts
    for index, part in enumerate(parts):
        if type(part) is Structure:
            answer = _ground_answer(agent, part)
            if answer is None:
                only = _only_candidate(agent, part)
                if only is not None:
                    extended = _extend(part, only, bindings)
                    if extended is None:
                        return None
                    bindings = extended
                    continue
                return _first_by_machine(agent, formula, And(parts[index:]) if index else formula, bindings)
            if not answer:
                return None
        elif isinstance(part, Not):
            if first(agent, part.part, bindings) is not None:
                return None
        elif isinstance(part, Comparison):
            if part.operator[0] == "=":  # `=` and `=..` bind variables, and the bindings given stay as they are
                bindings = dict(bindings)
            if not compare(part, bindings, [], agent.function):
                return None
        else:
            return _first_by_machine(agent, formula, And(parts[index:]), bindings)
    return bindings


def _ground_answer(agent: Reasoner, literal: Structure) -> bool | None:
    """Whether a ground literal is believed, if that can be looked up; None if it takes the machine."""
    if not literal.ground:
        return None
    bucket = agent.beliefs.bucket(literal.key)
    if not bucket:
        return literal.functor == "true" and not literal.args
    if literal.key in agent.beliefs.open and any(
        isinstance(entry, Rule) or not entry.ground for entry in bucket.values()
    ):
        return None  # a newer belief with variables may be the first answer
    held = bucket.get(literal.args)
    return isinstance(held, Structure) and all(annot in held.annots for annot in literal.annots)


def _only_candidate(agent: Reasoner, literal: Structure) -> Structure | None:
    """The one belief that can answer a query, in one way at most; None if it takes the machine."""
    # An expression is evaluated by the machine first; a tail takes the annotations that are left over.
    bucket = agent.beliefs.bucket(literal.key)
    if len(bucket) != 1 or literal.evaluable or literal.annots_tail is not None:
        return None
    if not all(map(is_ground, literal.annots)):
        return None
    (entry,) = bucket.values()
    if not isinstance(entry, Structure) or (literal.annots and not entry.ground):
        return None  # annotations with variables are more than looked up
    return entry


def _extend(literal: Structure, belief: Structure, bindings: Bindings) -> Bindings | None:
    """The bindings extended so that the literal is the belief; None if it cannot be."""
    extended = dict(bindings)
    trail: Trail = []
    for left, right in zip(literal.args, belief.args, strict=True):
        if type(left) is Variable and left not in extended and is_ground(right):
            extended[left] = right  # most arguments: without the calls of unify
        elif not unify(left, right, extended, trail):
            return None
    return extended if all(annot in belief.annots for annot in literal.annots) else None


def solve(agent: Reasoner, formula: Formula, bindings: Bindings) -> Iterator[Bindings]:
    """All solutions of a formula, each as new bindings that extend the given ones.

    Raises:
        BdiError: rules recurse without end.
        EvaluationError: an expression in it has no value.
    """
    agent.rule = None
    try:
        yield from _solve(agent, formula, bindings)
    except LimitError as error:
        error.rule = error.rule or _used_rule(agent)
        raise


def _used_rule(agent: Reasoner) -> str:
    """The rule that was used last, for the beginning of a message; empty if none was."""
    return "" if agent.rule is None else f"rule {agent.rule.head} ({agent.rule.location}), "


def _solve(agent: Reasoner, formula: Formula, bindings: Bindings) -> Iterator[Bindings]:
    env = dict(bindings)
    trail: Trail = []
    renamed: set[Variable] = set()
    choices: list[tuple[Iterator[Goals], int]] = []
    goals: Goals = (formula, None)
    while True:
        WORK.left -= 1
        if WORK.left < 0:
            raise too_much_work()
        if goals is None:
            yield _answer(agent, env, renamed)
        else:
            goal, rest = goals
            if isinstance(goal, And):
                # The parts go on the stack of goals, so that a long conjunction needs no frames of Python's.
                for part in reversed(goal.parts):
                    rest = (part, rest)
                goals = rest
                continue
            if isinstance(goal, Not):
                if first(agent, goal.part, env) is None:
                    goals = rest
                    continue
            elif isinstance(goal, Comparison):
                if compare(goal, env, trail, agent.function):
                    goals = rest
                    continue
            else:
                if len(choices) >= MAX_CHOICES:
                    raise BdiError(
                        f"{agent.name}: runaway recursion while looking for {goal}, more than {MAX_CHOICES:,} calls "
                        f"deep: {_used_rule(agent)}{agent.activity()}"
                    )
                choices.append((alternatives(agent, goal, rest, env, trail, renamed), len(trail)))
        while choices:
            ways, mark = choices[-1]
            # Also undo bindings that a failed goal made before it failed: unify and compare leave them.
            undo(env, trail, mark)
            try:
                goals = next(ways)
                break
            except StopIteration:
                choices.pop()
        else:
            return


def _answer(agent: Reasoner, env: Bindings, renamed: set[Variable]) -> Bindings:
    """The bindings for the outside: without the variables that rules brought in."""
    WORK.left -= len(env)
    if not renamed:
        return dict(env)
    return {
        variable: substitute(value, env, agent.function) for variable, value in env.items() if variable not in renamed
    }
