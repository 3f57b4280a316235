"""What follows from an agent's beliefs: resolution with backtracking, newest beliefs first.

The machine keeps its own stack of choices, so that deep rules cannot exhaust Python's, and stops
runaway recursion with an error that names the rule.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Protocol

from pytest_hricdv.bdi.language.errors import BdiError, EvaluationError
from pytest_hricdv.bdi.language.limits import WORK, LimitError, too_much_work
from pytest_hricdv.bdi.language.name_spaces import DEFAULT, LOCAL, split
from pytest_hricdv.bdi.language.syntax import And, Comparison, Formula, Not, Or, Rule
from pytest_hricdv.bdi.language.terms import (
    AnnotatedVariable,
    Call,
    FormulaTerm,
    QualifiedLiteral,
    Structure,
    Term,
    Variable,
    is_ground,
)
from pytest_hricdv.bdi.logic.beliefs import BeliefBase
from pytest_hricdv.bdi.logic.substitution import Bindings, rename_formula, substitute, substitute_only
from pytest_hricdv.bdi.logic.unify import Trail, compare, match_annotations, stands_for, undo, unify

MAX_CHOICES = 50_000
"""Open choices of one query: a recursion over a list has one for each item, and a rule that only calls itself reaches
this in two seconds."""
MAX_NESTED_QUERIES = 60
"""Queries within queries: Python's stack of 1,000 frames is exhausted at 325 through ``not``, at 121 through
``.findall``."""


class Reasoner(Protocol):
    """What a query needs of the agent that asks it."""

    name: str
    beliefs: BeliefBase
    rule: Rule | None
    """The rule that was used last, for error messages."""

    def function(self, call: Call, bindings: Bindings) -> Term:
        """The value of a function in an expression."""

    def call(self, call: Call, bindings: Bindings, trail: Trail) -> bool | Iterator[object]:
        """The outcome of an internal action as a condition; an iterator binds variables anew for each solution."""

    def fresh(self) -> Variable:
        """A variable that occurs nowhere else in the run."""

    def enter_query(self, formula: Formula) -> None:
        """Count a query inside another; raises a BdiError if there are too many."""

    def leave_query(self) -> None:
        """The end of a query."""

    def activity(self) -> str:
        """What the agent is doing, for error messages."""


Goals = tuple[Formula, Any] | None
"""What is left to show, first things first."""


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
                if len(choices) > MAX_CHOICES:
                    raise BdiError(
                        f"{agent.name}: runaway recursion while looking for {goal}, more than {MAX_CHOICES:,} calls "
                        f"deep: {_used_rule(agent)}{agent.activity()}"
                    )
                choices.append((_alternatives(agent, goal, rest, env, trail, renamed), len(trail)))
        while choices:
            alternatives, mark = choices[-1]
            # Also what a failed goal has bound before it failed: unify and compare leave that to this place.
            undo(env, trail, mark)
            try:
                goals = next(alternatives)
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


def _alternatives(
    agent: Reasoner, goal: Formula, rest: Goals, env: Bindings, trail: Trail, renamed: set[Variable]
) -> Iterator[Goals]:
    """What is left to show for each way to show the goal, with the bindings of that way made."""
    if isinstance(goal, Or):
        for part in goal.parts:
            yield (part, rest)
        return
    if not isinstance(goal, (Structure, Call)):
        goal = _meaning(agent, goal, env)  # type: ignore[assignment]
    if isinstance(goal, FormulaTerm):
        yield (goal.formula, rest)
        return
    if isinstance(goal, (Variable, AnnotatedVariable)):
        yield from _by_any_belief(agent, goal, rest, env, trail)
        return
    if isinstance(goal, QualifiedLiteral):
        yield from _in_any_space(agent, goal, rest, env, trail)
        return
    if isinstance(goal, Call):
        outcome = agent.call(goal, env, trail)
        if isinstance(outcome, bool):
            if outcome:
                yield rest
        else:
            for _ in outcome:
                yield rest
        return
    literal = _literal(agent, goal, env)  # type: ignore[arg-type]
    if literal.functor in ("true", "false") and not literal.args:
        if literal.functor == "true":
            yield rest
        return
    for entry in agent.beliefs.candidates(literal.key):
        WORK.left -= 1  # those that do not match come back to nobody who counts
        if isinstance(entry, Rule):
            yield from _by_rule(agent, literal, entry, rest, env, trail, renamed)
        else:
            yield from _by_belief(literal, entry, rest, env, trail)


def _meaning(agent: Reasoner, goal: Formula, env: Bindings) -> Formula | FormulaTerm:
    """What a variable in the place of a condition stands for: what was handed over, or itself if it has no value."""
    value = substitute(goal, env, agent.function)  # type: ignore[arg-type]
    if not isinstance(value, (Structure, Call, FormulaTerm, Variable, AnnotatedVariable, QualifiedLiteral)):
        raise EvaluationError(f"{goal} is not a literal but {value}")
    return value


def _literal(agent: Reasoner, goal: Structure, env: Bindings) -> Structure:
    if not goal.evaluable:
        return goal
    value = substitute(goal, env, agent.function)
    assert isinstance(value, Structure)
    return value


def _by_any_belief(
    agent: Reasoner, variable: Variable | AnnotatedVariable, rest: Goals, env: Bindings, trail: Trail
) -> Iterator[Goals]:
    """As in Jason, a variable without a value asks for every belief, of one predicate after the other."""
    mark = len(trail)
    for key in list(agent.beliefs.buckets):
        if split(key[1])[0] != DEFAULT:  # those of other name spaces are asked for with their name
            continue
        for entry in agent.beliefs.candidates(key):
            if isinstance(entry, Rule):
                continue
            if isinstance(variable, Variable):
                if unify(variable, entry, env, trail):
                    yield rest
            elif variable.negated <= entry.negated:
                env[variable.variable] = stands_for(variable, entry)
                trail.append(variable.variable)
                yield from _with_annotations(variable, entry.annots, rest, env, trail, mark)
            undo(env, trail, mark)


def _in_any_space(agent: Reasoner, goal: QualifiedLiteral, rest: Goals, env: Bindings, trail: Trail) -> Iterator[Goals]:
    """A literal whose name space is not known asks for those of all, that without a name first."""
    mark = len(trail)
    for key in sorted(agent.beliefs.buckets, key=lambda key: "::" in key[1]):
        negated, functor, arity = key
        space, name = split(functor)
        literal = goal.literal
        if space.startswith(LOCAL) and goal.space != Structure(space):
            continue  # seen by its name only
        if not isinstance(literal, Structure):
            for entry in agent.beliefs.candidates(key):
                if isinstance(entry, Structure) and unify(goal, entry, env, trail):
                    yield rest
                undo(env, trail, mark)
        elif (negated, name, arity) == literal.key and unify(goal.space, Structure(space), env, trail):
            yield (Structure(functor, literal.args, literal.annots, negated, literal.annots_tail), rest)
        undo(env, trail, mark)


def _by_belief(literal: Structure, belief: Structure, rest: Goals, env: Bindings, trail: Trail) -> Iterator[Goals]:
    mark = len(trail)
    for left, right in zip(literal.args, belief.args, strict=True):
        if not unify(left, right, env, trail):
            undo(env, trail, mark)
            return
    if not literal.annots and literal.annots_tail is None:
        yield rest
    else:
        yield from _with_annotations(literal, belief.annots, rest, env, trail, mark)


def _with_annotations(
    literal: Structure | AnnotatedVariable,
    annots: tuple[Term, ...],
    goals: Goals,
    env: Bindings,
    trail: Trail,
    mark: int,
) -> Iterator[Goals]:
    """Go on once for each way the annotations match; each way binds anew what was bound since ``mark``."""
    # All ways first: a suspended generator would have to find the bindings as it left them.
    ways = [
        [(variable, env[variable]) for variable in trail[mark:]] for _ in match_annotations(literal, annots, env, trail)
    ]
    # The arguments of this belief must not stay bound for the next one, also where no way is left.
    undo(env, trail, mark)
    for way in ways:
        for variable, value in way:
            env[variable] = value
            trail.append(variable)
        yield goals


def _by_rule(
    agent: Reasoner, literal: Structure, rule: Rule, rest: Goals, env: Bindings, trail: Trail, renamed: set[Variable]
) -> Iterator[Goals]:
    agent.rule = rule
    # New variables in each use: a rule that calls itself has those of its caller still bound.
    renaming: Bindings = {variable: agent.fresh() for variable in rule.variables}
    renamed.update(renaming.values())  # type: ignore[arg-type]
    head = substitute_only(rule.head, renaming) if renaming else rule.head
    mark = len(trail)
    if isinstance(head, Structure) and all(
        unify(left, right, env, trail) for left, right in zip(literal.args, head.args, strict=True)
    ):
        body = rename_formula(rule.body, renaming) if renaming else rule.body
        if not literal.annots and literal.annots_tail is None:
            yield (body, rest)
        else:
            yield from _with_annotations(literal, head.annots, (body, rest), env, trail, mark)
    else:
        undo(env, trail, mark)
