"""Statements numbered in the order of the text, and where to go on after each."""

from __future__ import annotations

from pytest_hricdv.bdi.language.syntax import Body, For, If, Plan, Statement, While
from pytest_hricdv.bdi.language.syntax_tree import parts_of
from pytest_hricdv.bdi.language.terms import Variable

Numbered = tuple[int, Statement]


def variables_in(node: object) -> tuple[Variable, ...]:
    """The variables in a part of a program, in order of appearance."""
    return tuple(dict.fromkeys(part for part in parts_of(node) if isinstance(part, Variable)))


class Layout:
    """The statements of a plan by number.

    Args:
        plan: the plan.
    """

    def __init__(self, plan: Plan) -> None:
        self.body = plan.body
        self.end = size(plan.body)
        """The number after the last one: where the plan is finished."""
        self.after = [self.end] * self.end
        self.statements: list[Numbered] = []
        self._number(plan.body, 0, self.end)
        self.loops = tuple(pc for pc, statement in self.statements if isinstance(statement, (For, While)))
        self.variables = variables_in(plan.body)

    def _number(self, body: Body, start: int, then: int) -> None:
        numbered = list(number(body, start))
        for place, (pc, statement) in enumerate(numbered):
            self.after[pc] = numbered[place + 1][0] if place + 1 < len(numbered) else then
            self.statements.append((pc, statement))
            for block, inside in blocks(statement, pc):
                self._number(block, inside, self.after[pc] if isinstance(statement, If) else pc)


def number(body: Body, start: int) -> tuple[Numbered, ...]:
    """The statements of a block with their numbers."""
    numbered = []
    for statement in body:
        numbered.append((start, statement))
        start += 1 + sum(size(block) for block, _ in blocks(statement, start))
    return tuple(numbered)


def blocks(statement: Statement, pc: int) -> list[tuple[Body, int]]:
    """The blocks of a statement with the number of their first statement."""
    if isinstance(statement, If):
        return [(statement.then, pc + 1), (statement.otherwise, pc + 1 + size(statement.then))]
    if isinstance(statement, (For, While)):
        return [(statement.body, pc + 1)]
    return []


def size(body: Body) -> int:
    """The number of statements, those in blocks included."""
    return sum(1 + sum(size(block) for block, _ in blocks(statement, 0)) for statement in body)
