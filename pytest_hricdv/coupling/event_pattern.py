"""Event patterns: an event of a run, and the literal that it stands for in an agent."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from pytest_hricdv._base.suggestion import nearest
from pytest_hricdv.bdi import Structure, Term, Variable
from pytest_hricdv.bdi.language.syntax_tree import variables_of
from pytest_hricdv.bdi.logic.substitution import substitute_only
from pytest_hricdv.coupling.agent_names import AgentNames
from pytest_hricdv.coupling.percept_mapping import PERCEPT, CouplingError, PerceptMapping
from pytest_hricdv.coupling.terms import term_of
from pytest_hricdv.monitor import FormulaSource, PastFormula, Value, Vocabulary, parse_condition
from pytest_hricdv.monitor.analysis import topics_of

Bindings = dict[Variable, Term]


@dataclass(frozen=True)
class EventPattern:
    """A pattern of a literal, and the condition that fills in its variables.

    Args:
        owner: names the declaration in errors.
        pattern: the literal; None for a plan's label.
        condition: when it happens.
        sources: variable -> the signal or `topic.field` that it stands for.
    """

    owner: str
    pattern: Structure | None
    condition: PastFormula
    sources: Mapping[Variable, str]

    def bindings(self, values: Mapping[str, Value]) -> Bindings:
        """The values of the variables, by the last values of signals and fields.

        Raises:
            CouplingError: a signal has no value yet.
        """
        if unknown := [name for name in self.sources.values() if name not in values]:
            raise CouplingError(f"{self.owner}: {unknown[0]} has no value yet; signals need one from the start")
        return {variable: term_of(values[name]) for variable, name in self.sources.items()}

    def literal(self, bindings: Bindings) -> Structure:
        """The pattern with its variables replaced."""
        literal = None if self.pattern is None else substitute_only(self.pattern, bindings)
        assert isinstance(literal, Structure), self.owner
        return literal


def parse_event(owner: str, pattern: Structure | None, when: str, vocabulary: Vocabulary) -> EventPattern:
    """The event that a declaration means.

    Raises:
        CouplingError: a variable of the literal that nothing in the run is called after.
        RequirementError: the condition does not parse, or holds for a time.
    """
    source = FormulaSource(when, owner=owner)
    condition = parse_condition(when, vocabulary, source)
    if not condition.is_instantaneous:
        advice = "it holds for a time; name the event: on(topic) & ..., rise(...), or fall(...)"
        raise source.error(0, len(when), "expected an event", advice)
    return EventPattern(owner, pattern, condition, _sources(owner, pattern, condition, vocabulary))


def parse_heard(
    declared: Iterable[PerceptMapping], names: AgentNames, others: Iterable[str], vocabulary: Vocabulary
) -> tuple[EventPattern, ...]:
    """The events that an agent hears.

    Args:
        declared: what it hears.
        names: of the agent.
        others: the other agents of the model.
        vocabulary: signals and messages.

    Raises:
        CouplingError: a literal or a source that the model does not have, or as `parse_event`.
        RequirementError: as `parse_event`.
    """
    declared, others = tuple(declared), tuple(others)
    for hears in declared:
        if hears.source != PERCEPT and hears.source not in others:
            raise CouplingError(f"{hears.owner}: no agent {hears.source!r}{nearest(hears.source, others)}")
    return tuple(
        parse_event(hears.owner, names.literal_of_percept(hears), hears.when, vocabulary) for hears in declared
    )


def _sources(
    owner: str, pattern: Structure | None, condition: PastFormula, vocabulary: Vocabulary
) -> dict[Variable, str]:
    fields = {
        field: f"{topic}.{field}" for topic in sorted(topics_of([condition])) for field in vocabulary.messages[topic]
    }
    # A field of the event's own message comes before a signal of the same name.
    sources = {name: name for name in vocabulary.signals} | fields
    bound: dict[Variable, str] = {}
    for variable in sorted(variables_of(pattern)) if pattern is not None else ():
        name = variable[:1].lower() + variable[1:]
        if name not in sources:
            raise CouplingError(
                f"{owner}: {variable} is neither a field of its message nor a signal{nearest(name, sources)}"
            )
        bound[variable] = sources[name]
    return bound
