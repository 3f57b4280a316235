"""Plan contexts compiled for repeated evaluation: `condition_of` makes a function of a context for the plan library.

Such a function gives the answer of :func:`~pytest_hricdv.bdi.logic.inference.first` by looking up beliefs by
predicate and arguments, or the only belief of a predicate. Where a part of a context needs a choice between beliefs or
a rule, `ask` decides this part and the rest of the context, by ``first``.
"""

from __future__ import annotations

from collections.abc import Callable

from pytest_hricdv.bdi.language.syntax import And, Comparison, Formula, Not
from pytest_hricdv.bdi.language.terms import Structure, Term, Variable, is_ground
from pytest_hricdv.bdi.logic.alternatives import Reasoner
from pytest_hricdv.bdi.logic.inference import first
from pytest_hricdv.bdi.logic.substitution import Bindings
from pytest_hricdv.bdi.logic.unify import Trail, compare, unify

Condition = Callable[[Reasoner, Bindings], bool | None]
"""Whether a formula holds; adds to the bindings what its first solution adds, or, if it does not hold, anything.
None, with nothing added, if deciding it needs a choice between beliefs or a rule."""

_CONSTANTS = ("true", "false")


def ask(agent: Reasoner, formula: Formula, bindings: Bindings) -> bool:
    """Whether a formula holds; adds to the bindings what its first solution adds."""
    solution = first(agent, formula, bindings)
    if solution is None:
        return False
    if solution is not bindings:
        bindings.update(solution)
    return True


def condition_of(formula: Formula) -> Condition:
    """How to decide a formula."""
    if isinstance(formula, And):
        return _conjunction(formula)
    if isinstance(formula, Structure):
        return _literal(formula)
    if isinstance(formula, Not):
        return _negation(formula)
    if isinstance(formula, Comparison):
        return lambda agent, bindings: compare(formula, bindings, [], agent.function)
    return _leave_open


def _leave_open(agent: Reasoner, bindings: Bindings) -> bool | None:
    return None


def _conjunction(formula: And) -> Condition:
    if all(isinstance(part, Structure) and _is_proposition(part) for part in formula.parts):
        return _propositions(formula.parts)  # type: ignore[arg-type]
    # Each part with what is to be shown from there on.
    parts = [(condition_of(part), And(formula.parts[index:])) for index, part in enumerate(formula.parts)]

    def condition(agent: Reasoner, bindings: Bindings) -> bool | None:
        for decide, rest in parts:
            # The bindings are changed in place: after a part fails, they are not used any more.
            decided = decide(agent, bindings)
            if not decided:
                return decided if decided is False else ask(agent, rest, bindings)
        return True

    return condition


def _is_proposition(literal: Structure) -> bool:
    """Whether a literal asks for one belief with any sources."""
    return literal.ground and not literal.annots and literal.functor not in _CONSTANTS


def _propositions(literals: tuple[Structure, ...]) -> Condition:
    """For ground literals with any sources."""
    wanted = [(literal.key, literal.args) for literal in literals]

    def condition(agent: Reasoner, bindings: Bindings) -> bool | None:
        buckets = agent.beliefs.buckets
        for key, args in wanted:
            bucket = buckets.get(key)
            if key in agent.beliefs.open:  # a newer belief with variables may be the first answer
                return None
            if not bucket or args not in bucket:
                # Only here it matters whether there are other ways to answer.
                return None if agent.beliefs.open else False
        return True

    return condition


def _negation(formula: Not) -> Condition:
    # Bindings that a negated part makes before it fails must not leak; a ground literal binds nothing.
    part, decide = formula.part, condition_of(formula.part)
    copies = not (isinstance(part, Structure) and part.ground)

    def negation(agent: Reasoner, bindings: Bindings) -> bool | None:
        own = dict(bindings) if copies else bindings
        decided = decide(agent, own)
        return first(agent, part, own) is None if decided is None else not decided

    return negation


def _literal(literal: Structure) -> Condition:
    if literal.functor in _CONSTANTS or literal.evaluable or literal.annots_tail is not None:
        return _leave_open
    if literal.ground:
        return _ground_literal(literal)
    if not all(map(is_ground, literal.annots)):
        return _leave_open
    return _only_belief(literal)


def _ground_literal(literal: Structure) -> Condition:
    """For a ground literal."""
    key, args, annots = literal.key, literal.args, literal.annots

    def condition(agent: Reasoner, bindings: Bindings) -> bool | None:
        bucket = agent.beliefs.buckets.get(key)
        if not bucket:
            return False
        if key in agent.beliefs.open:  # a newer belief with variables may be the first answer
            return None
        held = bucket.get(args)
        return isinstance(held, Structure) and (not annots or _has_annotations(held, annots))

    return condition


def _only_belief(literal: Structure) -> Condition:
    """For a literal with variables: decided if the predicate has no belief, or only one and no rule."""
    key, args, annots = literal.key, literal.args, literal.annots
    only_names, places = all(isinstance(arg, Variable) for arg in args), range(len(args))

    def condition(agent: Reasoner, bindings: Bindings) -> bool | None:
        bucket = agent.beliefs.buckets.get(key)
        if not bucket:
            return False
        if len(bucket) != 1:
            return None
        (belief,) = bucket.values()
        if not isinstance(belief, Structure) or (annots and not belief.ground):
            return None  # annotations with variables are more than looked up
        if only_names and belief.ground:
            for place in places:
                value = belief.args[place]
                bound = bindings.setdefault(args[place], value)  # type: ignore[arg-type]
                if bound is not value and not unify(bound, value, bindings, []):
                    return False
        elif not _unify_all(args, belief.args, bindings):
            return False
        return not annots or _has_annotations(belief, annots)

    return condition


def _has_annotations(belief: Structure, annots: tuple[Term, ...]) -> bool:
    """Whether a belief has all of these ground annotations."""
    # Most are equal, as `[source(self)]`: tuples of the same objects are compared fast.
    return belief.annots == annots or all(annot in belief.annots for annot in annots)


def _unify_all(args: tuple[Term, ...], others: tuple[Term, ...], bindings: Bindings) -> bool:
    """Whether each argument unifies with the other in its place."""
    trail: Trail = []
    return all(unify(left, right, bindings, trail) for left, right in zip(args, others, strict=True))
