"""What is the same for a compiled agent in all runs."""

from __future__ import annotations

from ..beliefs import BeliefBase
from ..intentions import Letter
from ..library import PlanLibrary
from ..syntax import Rule
from ..terms import Key, Structure, in_order, source
from .activity import Pending, Store
from .program import Annots, ProgramCode, proposition


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
        self.letters = [_letter("self" if name == to else name, told, about) for to, told, about in program.letters]
        self.lines = [tuple((name, text) for text in texts) for texts in program.lines]
        self.program = program
        self.library = library
        self.propositions: dict[str, Annots] = {}
        self.tables: list[Store] = [{} for _ in program.tables]
        self.others: dict[Key, Store] = {}
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


def _letter(sender: str, told: bool, literal: Structure) -> Letter:
    return Letter(sender, told, literal, in_order((*literal.annots, source(sender))))
