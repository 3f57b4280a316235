"""What is the same for a compiled agent in all runs."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress

from pytest_hricdv.bdi.language.syntax import Rule
from pytest_hricdv.bdi.language.terms import Key, Structure, sorted_terms, source

from ..beliefs import BeliefBase
from ..intentions import Letter
from ..library import PlanLibrary
from .activity import Args, Pending
from .program import Annots, ProgramCode, Slot, proposition

MAX_KNOWN = 1000
"""Messages kept to be sent again; when there are more, all are forgotten."""


class AgentCode:
    """The program of an agent, and how it begins.

    Args:
        name: its name.
        program: the compiled form of its program.
        beliefs: what it believes at first, without rules.
        library: its plans.
        events: what it has to react to at first.
    """

    def __init__(
        self,
        name: str,
        program: ProgramCode,
        beliefs: BeliefBase,
        library: PlanLibrary,
        events: list[tuple[str, Structure]],
    ) -> None:
        self.name = name
        self.letters: list[Letter] = []
        """The messages that it sends that are always the same."""
        self.known: dict[object, Letter] = {}
        """Other messages that it has sent, by the number of their form and by what is filled in."""
        self.lines = [tuple((name, text) for text in texts) for texts in program.lines]
        self.program = program
        self.library = library
        self.propositions: dict[str, Annots] = {}
        self.tables: list[dict[Slot, Annots]] = [{} for _ in program.tables]
        self.others: dict[Key, dict[Slot, Annots]] = {}
        for belief in beliefs:
            assert not isinstance(belief, Rule)
            if not belief.args:
                self.propositions[proposition(belief)] = belief.annots
            elif belief.key in program.tables:
                self.tables[program.tables[belief.key]][belief.args] = belief.annots
            else:
                self.others.setdefault(belief.key, {})[belief.args] = belief.annots
        self.events: list[Pending] = [
            ((program.trigger(sign, literal.key), literal.args, literal.annots), None) for sign, literal in events
        ]

    def address(self, codes: Mapping[str, AgentCode]) -> None:
        """Write the letters, to agents of whom those are compiled."""
        self._codes = codes
        self.letters = [self._letter(*letter) for letter in self.program.letters]

    def letter(self, form: int, content: Args | Structure) -> Letter:
        """Write the message of a form with these arguments, or with this content."""
        to, told, literal = self.program.forms[form]
        filled = content
        if isinstance(content, tuple):
            assert literal is not None
            filled = Structure(literal.functor, content, (), literal.negated)
        assert isinstance(filled, Structure)
        letter = self._letter(to, told, filled)
        if len(self.known) >= MAX_KNOWN:
            self.known.clear()
        with suppress(RecursionError):
            # What is nested too deeply is not kept.
            self.known[form, content] = letter
        return letter

    def _letter(self, to: str, told: bool, literal: Structure) -> Letter:
        sender = "self" if to == self.name else self.name
        annots: Annots = (source(sender),)
        if literal.annots:
            annots = sorted_terms(literal.annots + annots)
        if to not in self._codes:
            return Letter(sender, told, literal, annots, None, (), None)
        program = self._codes[to].program
        trigger = program.noticed.get(literal.key) if told else program.trigger("+!", literal.key)
        event = None if trigger is None else ((trigger, literal.args, annots), None)
        place = program.tables.get(literal.key) if literal.args else -1
        slot = literal.args or proposition(literal)
        return Letter(sender, told, literal, annots, place, slot, event)
