"""The memo's analysis of steering agents, which only forward percepts, and its record of what a run depends on.

`Memo` calls `find_forwarding`, which recognizes such an agent; `Dependencies` notes which beliefs receivers query.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from pytest_hricdv.bdi.agent.plan_library import PlanLibrary
from pytest_hricdv.bdi.language.syntax import For, InternalActionCall, Plan, Statement
from pytest_hricdv.bdi.language.syntax_tree import parts_of, variables_of
from pytest_hricdv.bdi.language.terms import SOURCE_PERCEPT, Key, Structure, Term, Variable, source
from pytest_hricdv.bdi.logic.beliefs import BeliefBase, Content, Entry, TrackedBuckets
from pytest_hricdv.bdi.run.environment import percept_of
from pytest_hricdv.bdi.run.system import AgentTemplate


class ForwardingRule:
    """How an agent forwards its percepts ``f(b)``: it tells ``b`` to other agents and does nothing else with them.

    Args:
        steering: the agent.
        key: the key of the percepts.
        receivers: the agents that it tells.
        special: atoms that are not handled alike: its own program mentions them, or they mean something to a receiver
            when they come.
    """

    def __init__(self, steering: str, key: Key, receivers: frozenset[str], special: frozenset[str]) -> None:
        self.steering = steering
        self.key = key
        self.receivers = receivers
        self.atoms = _Atoms(key, special)
        """Percept -> the atom that it is about; empty if it is not forwarded like the others."""

    def belief(self, atom: str) -> Structure:
        """The belief of a receiver to which an atom has been forwarded."""
        return Structure(atom, (), (source(self.steering),))


class _Atoms(dict[str | Structure, str]):
    """The atoms of percepts, found when they are first used."""

    def __init__(self, key: Key, special: frozenset[str]) -> None:
        super().__init__()
        self._key = key
        self._special = special

    def __missing__(self, percept: str | Structure) -> str:
        self[percept] = atom = self._atom(percept_of(percept))
        return atom

    def _atom(self, percept: Structure) -> str:
        if percept.key != self._key or percept.annots != (SOURCE_PERCEPT,):
            return ""
        (about,) = percept.args
        if not isinstance(about, Structure) or about.args or about.annots or about.negated:
            return ""
        return "" if about.functor in self._special else about.functor


def find_forwarding(name: str, key: Key, templates: Sequence[AgentTemplate]) -> ForwardingRule | None:
    """Find how an agent forwards the percepts of a predicate; None if it does anything else with them.

    Args:
        key: the key of the percepts.
    """
    agents = {template.name: template for template in templates}
    agent = agents.get(name)
    if agent is None or key[2] != 1 or any(held == key for held, _ in agent.beliefs):
        return None
    forwarded = _find_receivers(agent.library, key)
    if forwarded is None or name in forwarded[0]:
        return None
    receivers, special = forwarded
    for receiver in receivers:
        meaning = _meaningful_atoms(agents[receiver]) if receiver in agents else None
        if meaning is None:
            return None
        special |= meaning
    return ForwardingRule(name, key, frozenset(receivers), frozenset(special))


def _meaningful_atoms(receiver: AgentTemplate) -> set[str] | None:
    """The atoms that a receiver reacts to or believes initially; None if unknown."""
    triggers = [plan.trigger for plan in receiver.library.plans if plan.trigger.sign == "+"]
    if receiver.library.has_own_message_plans or not all(
        isinstance(trigger.literal, Structure) for trigger in triggers
    ):
        return None
    believed = {functor for (_, functor, _), _ in receiver.beliefs}
    return believed | {trigger.literal.functor for trigger in triggers if isinstance(trigger.literal, Structure)}


def _find_receivers(library: PlanLibrary, key: Key) -> tuple[set[str], set[str]] | None:
    """The receivers of percepts of a key, and the atoms that the program mentions; None if anything else is done."""
    plans = [plan for plan in library.plans if not plan.builtin]
    if not all(isinstance(plan.trigger.literal, Structure) for plan in plans):
        return None
    receivers: set[str] = set()
    loops = [loop for plan in plans for loop in _statements(plan.body) if isinstance(loop, For) and _asks(loop, key)]
    for loop in loops:
        (variable,) = variables_of(loop.condition)
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
    return plain and len(variables_of(asked)) == 1


def _forwards(statement: Statement, variable: Term) -> bool:
    """Whether a statement tells a named agent what a variable stands for."""
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


class Dependencies:
    """The dependencies of the recorded part of a run.

    Args:
        forwarding: how the atoms are forwarded.
        arrived: whether they have been forwarded already.
    """

    def __init__(self, forwarding: ForwardingRule, atoms: frozenset[str], arrived: bool) -> None:
        self.forwarding = forwarding
        self.atoms = atoms
        self.certain = True
        """Whether other runs may rely on what is recorded."""
        self.missing = 0 if arrived else len(atoms) * len(forwarding.receivers)
        """Atoms that are still to arrive."""
        self.looks = int(arrived)
        """How often the steering agent has queried its percepts."""
        self.answers: dict[str, bool] = {}
        """The atoms queried in the current segment, in order, and whether they are among those forwarded."""

    @property
    def is_done(self) -> bool:
        """Whether the steering agent has done its part."""
        return not self.missing and self.looks == 1

    def note_query(self, atom: str, answer: bool) -> None:
        """A receiver has queried whether it holds an atom that could only have been forwarded to it."""
        if self.missing:
            self.certain = False
        self.answers.setdefault(atom, answer)

    def note_look(self) -> None:
        """The steering agent has queried its percepts."""
        self.looks += 1
        if self.looks > 1:
            self.certain = False


class ReceiverBeliefs(BeliefBase):
    """The beliefs of a receiver, which record queries of atoms that could be forwarded to it.

    Args:
        content: what it believes for certain; a predicate without entries is certainly not believed.
        dependencies: where to note queries.
        forwarded: the atoms that have been forwarded to it.
    """

    __slots__ = ("_dependencies", "_settled", "_tracked")

    def __init__(
        self, content: Iterable[tuple[Key, tuple[Entry, ...]]], dependencies: Dependencies, forwarded: Iterable[str]
    ) -> None:
        content = tuple(content)
        super().__init__(content)
        self._dependencies = dependencies
        self._settled = {key for key, _ in content}
        """The predicates that do not depend on the forwarded atoms."""
        for atom in forwarded:
            belief = dependencies.forwarding.belief(atom)
            if belief.key not in self._settled:
                self.buckets[belief.key] = {(): belief}
        self.buckets = self._tracked = TrackedBuckets(self.buckets, self._note_read)

    def _note_read(self, key: Key) -> None:
        if self._depends(key):
            self._dependencies.note_query(key[1], self.holds(key))

    def _depends(self, key: Key) -> bool:
        negated, _, arity = key
        return not arity and not negated and key not in self._settled

    def holds(self, key: Key) -> bool:
        """Whether there is any belief of a predicate; this is not noted."""
        return bool(self._tracked.peek(key))

    def arrive(self, belief: Structure) -> None:
        """Add an atom that has been forwarded; this is not noted."""
        self.buckets[belief.key] = {(): belief}
        self.version += 1

    def add(self, belief: Structure) -> Structure | None:
        """Add a belief: from then on it is certain."""
        new = super().add(belief)
        if new is not None:
            self._settled.add(belief.key)
        return new

    def remove(self, belief: Structure) -> bool:
        """Remove a belief: from then on it is certain."""
        removed = super().remove(belief)
        if removed:
            self._settled.add(belief.key)
        return removed

    def content(self) -> Content:
        """The state without the forwarded atoms."""
        held: dict[Key, tuple[Entry, ...]] = {key: () for key in self._settled if self._is_proposition(key)}
        for key, bucket in self.buckets.items():
            if bucket and not self._depends(key):
                held[key] = tuple(bucket.values())
        return tuple(held.items())

    @staticmethod
    def _is_proposition(key: Key) -> bool:
        return not key[0] and not key[2]


class SteeringBeliefs(BeliefBase):
    """The beliefs of the steering agent after perception, which record queries of the forwarded percepts.

    Args:
        dependencies: where to note queries.
    """

    __slots__ = ("_dependencies",)

    def __init__(self, beliefs: BeliefBase, dependencies: Dependencies) -> None:
        super().__init__()
        self.open = beliefs.open
        self._dependencies = dependencies
        self.buckets = TrackedBuckets(beliefs.buckets, self._note_read)

    def _note_read(self, key: Key) -> None:
        if key == self._dependencies.forwarding.key:
            self._dependencies.note_look()

    def content(self) -> Content:
        """Its beliefs besides the percepts to be forwarded."""
        return tuple([entry for entry in super().content() if entry[0] != self._dependencies.forwarding.key])
