"""Consecutive statements in one piece, for when there are cycles enough for all of them.

Such statements concern nobody but the agent, or are actions in the plain environment: while cycles are left,
nothing can come between them, so that where the activity is need not be kept up to date.
"""

from __future__ import annotations

from pytest_hricdv.bdi.language.syntax import BeliefUpdate, ExternalAction, InternalActionCall, Statement
from pytest_hricdv.bdi.language.terms import SOURCE_PERCEPT, Structure

from .bodies import FINISH, FINISH_ACTED, BodyWriter
from .layout import Numbered
from .program import proposition
from .values import Scope, may_bail, trusting, value

_PRINTS = frozenset({".print", ".println"})


class StraightWriter:
    """Writes a run of statements in one piece.

    Args:
        body: the body they are part of.
        numbered: the statements.
        scope: the variables bound before; such statements bind none.
    """

    def __init__(self, body: BodyWriter, numbered: tuple[Numbered, ...], scope: Scope) -> None:
        self._body = body
        self._writer = body.writer.beside()
        self._numbered = numbered
        self._scope = scope
        self._texts: list[str] = []
        """The actions to be noted next."""
        self._numbers: dict[str, None] = {}
        """The variables that have to stand for numbers."""

    def write(self) -> None:
        """Write the statements, and afterwards go on at the one that follows them.

        Raises:
            UnsupportedError: some statement has no compiled form.
        """
        count = len(self._numbered)
        for done, (pc, statement) in enumerate(self._numbered):
            if not isinstance(statement, ExternalAction) or not self._is_constant(statement):
                self._note_actions()
            self._statement(pc, done, statement)
        self._note_actions()
        self._writer.line(f"n -= {count}")
        first, last = self._numbered[0][0], self._numbered[-1][0]
        self._go_on(last, self._numbered[-1][1])
        conditions = [f"pc == {first}", f"n > {count}", *(f"type({name}) is Number" for name in self._numbers)]
        if any(isinstance(each, ExternalAction) for _, each in self._numbered):
            conditions.append("a.acts_alone")
        with self._body.writer.block(f"if {' and '.join(conditions)}:"):
            self._body.save_values()
            self._body.writer.include(self._writer.lines)

    def write_actions(self) -> bool:
        """Write the statements one by one if all are actions that are always the same; whether they are."""
        if not all(isinstance(each, ExternalAction) and self._is_constant(each) for _, each in self._numbered):
            return False
        writer, plan = self._body.writer, self._body.plan
        first, last = self._numbered[0][0], self._numbered[-1][0]
        actions = [(each.action, plan, each) for _, each in self._numbered if isinstance(each, ExternalAction)]
        where = "pc" if first == 0 else f"pc - {first}"
        self._body.save_values()
        with writer.block(f"while pc <= {last}:"):
            writer.line(f"n = act(a, i, pc, *{writer.names.constant(tuple(actions))}[{where}], n)")
            writer.line("if n <= 0: return n")
            writer.line("pc += 1")
        self._writer = writer
        self._go_on(last, self._numbered[-1][1])
        return True

    def _go_on(self, pc: int, statement: Statement) -> None:
        after = self._body.layout.after[pc]
        if after != self._body.layout.end:
            self._writer.line(f"pc = {after}")
        elif isinstance(statement, ExternalAction):
            self._writer.line(f"return {FINISH_ACTED}")
        else:
            self._writer.line(f"return {FINISH}")

    def _statement(self, pc: int, done: int, statement: Statement) -> None:
        if isinstance(statement, ExternalAction):
            self._act(pc, done, statement)
        elif isinstance(statement, BeliefUpdate):
            self._believe(pc, done, statement)
        elif isinstance(statement, InternalActionCall) and statement.call.name in _PRINTS:
            from .statements import printed

            text = self._with_numbers(printed(self._body, statement.call, self._scope))
            self._mark_for(pc, done, text)
            self._writer.line(text)
        elif isinstance(statement, InternalActionCall):
            (pattern,) = statement.call.args
            assert isinstance(pattern, Structure)
            self._writer.line(f"abolish(a, p, ({proposition(pattern)!r},), {self._body.trigger('-', pattern)})")

    def _with_numbers(self, expression: str) -> str:
        """An expression without looking whether variables stand for numbers: that is done once for all."""
        trusted, variables = trusting(expression)
        self._numbers.update(dict.fromkeys(variables))
        return trusted

    def _mark_for(self, pc: int, done: int, *expressions: str) -> None:
        """Note where the activity is if an expression may have no value."""
        if may_bail(*expressions):
            self._writer.line(f"i.pc = {pc}")
            self._writer.line(f"i.left = n - {done}" if done else "i.left = n")

    def _is_constant(self, statement: ExternalAction) -> bool:
        return isinstance(statement.action, Structure) and statement.action.ground

    def _act(self, pc: int, done: int, statement: ExternalAction) -> None:
        if self._is_constant(statement):
            self._texts.append(str(statement.action))
            return
        action = self._with_numbers(value(self._writer, statement.action, self._scope))
        self._mark_for(pc, done, action)
        self._writer.line(f"note_action(a, {action})")

    def _note_actions(self) -> None:
        if self._texts:
            lines = self._body.program.lines
            lines.append(tuple(self._texts))
            self._texts = []
            self._writer.line(f"note(a, {len(lines) - 1})")

    def _believe(self, pc: int, done: int, statement: BeliefUpdate) -> None:
        body, writer, sign = self._body, self._writer, statement.sign
        literal, args, annots = body.posted(statement.literal, self._scope)
        if not literal.args:
            if sign == "-+":
                lost = body.trigger("-", literal)
                writer.line(f"displace(a, p, {proposition(literal)!r}, {annots}, {lost})")
            writer.line(f"{'remove' if sign == '-' else 'add'}(a, p, {proposition(literal)!r}, {annots})")
            return
        args = self._with_numbers(args)
        self._mark_for(pc, done, args)
        change = {"-": "remove", "+": "add", "-+": "replace"}[sign]
        writer.line(f"{change}(a, {body.program.table(literal)}, {args}, {annots})")


def straight_run(body: BodyWriter, numbered: tuple[Numbered, ...]) -> tuple[Numbered, ...]:
    """Those of the statements, from the first on, that can be done in one piece."""
    count = 0
    while count < len(numbered) and _is_straight(body, *numbered[count]):
        count += 1
    return numbered[:count]


def _is_straight(body: BodyWriter, pc: int, statement: Statement) -> bool:
    if isinstance(statement, ExternalAction):
        return isinstance(statement.action, Structure)
    if isinstance(statement, BeliefUpdate):
        literal, signs = statement.literal, statement.sign
        if not isinstance(literal, Structure) or signs == "++" or SOURCE_PERCEPT in literal.annots:
            return False
        # At the end of a plan it makes a difference whether there is an event, as it does where plans are for it.
        is_last = body.layout.after[pc] == body.layout.end
        return not is_last and not any(body.has_plans(sign, literal) for sign in signs)
    if not isinstance(statement, InternalActionCall):
        return False
    call = statement.call
    if call.name == ".abolish" and len(call.args) == 1:
        # With arguments it may have to look at several beliefs, and with annotations it is not compiled.
        pattern = call.args[0]
        if not isinstance(pattern, Structure) or not pattern.ground or pattern.args or pattern.annots:
            return False
        return not body.has_plans("-", pattern)
    return call.name in _PRINTS
