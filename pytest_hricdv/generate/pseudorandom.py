"""Pseudorandom: the baseline without a model, a random sequence of commands."""

from __future__ import annotations

from dataclasses import dataclass

from .error import GenerateError
from .identity import Draft
from .method import Context
from .stream import index, pick, stream
from .suite import Generation, Suite
from .text import actions_aim


@dataclass(frozen=True)
class Pseudorandom:
    """The paper's baseline: 100 tests by default, of `Context.lengths` commands, each drawn from all."""

    name: str = "pseudorandom"
    size: int = 100

    def generate(self, context: Context) -> Suite:
        """Draw the tests, each from a stream of its own.

        Raises:
            GenerateError: no command can be enacted.
        """
        if not context.commands:
            raise GenerateError("pseudorandom tests need the commands that can be enacted, but the testbench has none")
        drafts = [self._draw(context, number) for number in range(context.tests or self.size)]
        return Suite.of_drafts(self.name, context.seed, drafts, Generation())

    def _draw(self, context: Context, number: int) -> Draft:
        random = stream(self.name, context.seed, number)
        fewest, most = context.lengths
        length = fewest + index(random, most - fewest + 1)
        lines = tuple(pick(random, context.commands) for _ in range(length))
        return Draft(actions_aim(lines), (), lines)
