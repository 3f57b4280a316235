"""Which agents forward their percepts, and to whom."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from pytest_hricdv.bdi.language.syntax import For, InternalActionCall, Plan, Statement
from pytest_hricdv.bdi.language.syntax_tree import parts_of
from pytest_hricdv.bdi.language.terms import Key, Structure, Term, Variable

from ..compiled.layout import variables_in
from ..library import PlanLibrary
from ..prototype import Prototype


@dataclass(frozen=True, slots=True)
class Forwarding:
    """An agent's way with the percepts ``f(b)``: it does nothing but tell others ``b``.

    Args:
        steering: the agent.
        key: of the percepts.
        receivers: whom it tells.
        special: atoms that are not handled alike: its own program mentions them, or they mean something to a receiver
            when they come.
    """

    steering: str
    key: Key
    receivers: frozenset[str]
    special: frozenset[str]


def forwarding_of(name: str, key: Key, prototypes: Mapping[str, Prototype]) -> Forwarding | None:
    """How an agent forwards the percepts of a key; None if it does anything else with them.

    Args:
        name: of the agent.
        key: of the percepts.
        prototypes: all agents by their names.
    """
    agent = prototypes.get(name)
    if agent is None or agent.code is None or key[2] != 1:
        return None
    place = agent.code.program.tables.get(key)
    if place is None or agent.code.tables[place]:
        return None
    found = _forwarded(agent.library, key)
    if found is None or name in found[0]:
        return None
    receivers, special = found
    for receiver in receivers:
        received = prototypes[receiver].code if receiver in prototypes else None
        if received is None:
            return None
        special |= received.propositions.keys() | {functor for _, functor, _ in received.program.noticed}
    return Forwarding(name, key, frozenset(receivers), frozenset(special))


def _forwarded(library: PlanLibrary, key: Key) -> tuple[set[str], set[str]] | None:
    """Who is told of percepts of a key, and the atoms that the program mentions; None if anything else is done."""
    plans = [plan for plan in library.plans if not plan.builtin]
    receivers: set[str] = set()
    loops = [loop for plan in plans for loop in _statements(plan.body) if isinstance(loop, For) and _asks(loop, key)]
    for loop in loops:
        (variable,) = variables_in(loop.condition)
        sends = [statement for statement in _statements(loop.body) if _forwards(statement, variable)]
        if _count(loop.body, variable) != len(sends):
            return None
        receivers |= {str(send.call.args[0]) for send in sends if isinstance(send, InternalActionCall)}
        if any(_count(plan, variable) > _count(loop, variable) for plan in plans if loop in _statements(plan.body)):
            return None
    mentions = sum(_mentions(plan, key) for plan in plans)
    if not loops or mentions != len(loops):
        return None
    atoms = {part.functor for plan in plans for part in parts_of(plan) if isinstance(part, Structure) and not part.args}
    return receivers, atoms - receivers


def _asks(loop: For, key: Key) -> bool:
    """Whether a loop is over the beliefs of a key, whatever they are about."""
    asked = loop.condition
    plain = isinstance(asked, Structure) and asked.key == key and not asked.annots and asked.annots_tail is None
    return plain and len(variables_in(asked)) == 1


def _forwards(statement: Statement, variable: Term) -> bool:
    """Whether a statement tells an agent known beforehand what a variable stands for."""
    if not isinstance(statement, InternalActionCall) or statement.call.name != ".send" or len(statement.call.args) != 3:
        return False
    receiver, force, content = statement.call.args
    return isinstance(receiver, Structure) and str(force) == "tell" and content == variable


def _statements(body: object) -> list[Statement]:
    return [part for part in parts_of(body) if isinstance(part, Statement)]


def _count(node: object, variable: Term) -> int:
    return sum(isinstance(part, Variable) and part == variable for part in parts_of(node))


def _mentions(plan: Plan, key: Key) -> int:
    return sum(isinstance(part, Structure) and part.key == key for part in parts_of(plan))
