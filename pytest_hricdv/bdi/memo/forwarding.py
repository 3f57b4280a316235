"""Which agents forward their percepts, and to which others."""

from __future__ import annotations

from collections.abc import Sequence

from pytest_hricdv.bdi.agent.plan_library import PlanLibrary
from pytest_hricdv.bdi.language.syntax import For, InternalActionCall, Plan, Statement
from pytest_hricdv.bdi.language.syntax_tree import parts_of
from pytest_hricdv.bdi.language.terms import SOURCE_PERCEPT, Key, Structure, Term, Variable, source
from pytest_hricdv.bdi.run.agent_template import AgentTemplate
from pytest_hricdv.bdi.run.environment import percept_of


class Forwarding:
    """How an agent forwards the percepts ``f(b)``: all it does with them is to tell others ``b``.

    Args:
        steering: the agent.
        key: of the percepts.
        receivers: the agents that it tells.
        special: atoms that are not handled alike: its own program mentions them, or they mean something to a receiver
            when they come.
    """

    def __init__(self, steering: str, key: Key, receivers: frozenset[str], special: frozenset[str]) -> None:
        self.steering = steering
        self.key = key
        self.receivers = receivers
        self.atoms = _Atoms(key, special)
        """The atoms that percepts, as they were given, are about; empty if it is not forwarded like the others."""

    def belief(self, atom: str) -> Structure:
        """The belief of a receiver to which an atom has been forwarded."""
        return Structure(atom, (), (source(self.steering),))


class _Atoms(dict[str | Structure, str]):
    """The atoms of percepts, found when they are first used."""

    def __init__(self, key: Key, special: frozenset[str]) -> None:
        super().__init__()
        self._key = key
        self._special = special

    def __missing__(self, given: str | Structure) -> str:
        self[given] = atom = self._atom(percept_of(given))
        return atom

    def _atom(self, percept: Structure) -> str:
        if percept.key != self._key or percept.annots != (SOURCE_PERCEPT,):
            return ""
        (about,) = percept.args
        if not isinstance(about, Structure) or about.args or about.annots or about.negated:
            return ""
        return "" if about.functor in self._special else about.functor


def forwarding_of(name: str, key: Key, templates: Sequence[AgentTemplate]) -> Forwarding | None:
    """How an agent forwards the percepts of a predicate; None if it does anything else with them.

    Args:
        name: of the agent.
        key: of the percepts.
        templates: all agents.
    """
    agents = {template.name: template for template in templates}
    agent = agents.get(name)
    if agent is None or key[2] != 1 or any(held == key for held, _ in agent.beliefs):
        return None
    found = _forwarded(agent.library, key)
    if found is None or name in found[0]:
        return None
    receivers, special = found
    for receiver in receivers:
        meaning = _meaningful_atoms(agents[receiver]) if receiver in agents else None
        if meaning is None:
            return None
        special |= meaning
    return Forwarding(name, key, frozenset(receivers), frozenset(special))


def _meaningful_atoms(receiver: AgentTemplate) -> set[str] | None:
    """The atoms that mean something to a receiver when they come; None if that is not known."""
    triggers = [plan.trigger for plan in receiver.library.plans if plan.trigger.sign == "+"]
    if receiver.library.has_own_message_plans or not all(isinstance(each.literal, Structure) for each in triggers):
        return None
    believed = {functor for (_, functor, _), _ in receiver.beliefs}
    return believed | {trigger.literal.functor for trigger in triggers if isinstance(trigger.literal, Structure)}


def _forwarded(library: PlanLibrary, key: Key) -> tuple[set[str], set[str]] | None:
    """The receivers of percepts of a key, and the atoms that the program mentions; None if anything else is done."""
    plans = [plan for plan in library.plans if not plan.builtin]
    if not all(isinstance(plan.trigger.literal, Structure) for plan in plans):
        return None
    receivers: set[str] = set()
    loops = [loop for plan in plans for loop in _statements(plan.body) if isinstance(loop, For) and _asks(loop, key)]
    for loop in loops:
        (variable,) = _variables_in(loop.condition)
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
    return plain and len(_variables_in(asked)) == 1


def _forwards(statement: Statement, variable: Term) -> bool:
    """Whether a statement tells a named agent what a variable stands for."""
    if not isinstance(statement, InternalActionCall) or statement.call.name != ".send" or len(statement.call.args) != 3:
        return False
    receiver, force, content = statement.call.args
    return isinstance(receiver, Structure) and str(force) == "tell" and content == variable


def _variables_in(node: object) -> set[Variable]:
    return {part for part in parts_of(node) if isinstance(part, Variable)}


def _statements(body: object) -> list[Statement]:
    return [part for part in parts_of(body) if isinstance(part, Statement)]


def _count(node: object, variable: Term) -> int:
    return sum(isinstance(part, Variable) and part == variable for part in parts_of(node))


def _mentions(plan: Plan, key: Key) -> int:
    return sum(isinstance(part, Structure) and part.key == key for part in parts_of(plan))
