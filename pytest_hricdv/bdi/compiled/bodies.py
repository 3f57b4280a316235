"""Plan bodies as Python functions that can be left after any statement and taken up there again.

A function gets the agent ``a``, its beliefs without arguments ``p`` and those with, ``b``, the activity ``i`` to take
up at statement ``pc``, the values ``v`` of its variables, and ``n``, the cycles that it may do: more than one only
while nothing else can happen to the agent. Each statement costs one. It returns the cycles left if the activity can
use them now, and else the cycles not needed, negative: the activity has been put where the interpreter would have its
intention.
"""

from __future__ import annotations

from pytest_hricdv.bdi.language.formulas import Formula
from pytest_hricdv.bdi.language.syntax import (
    Body,
    ConditionStatement,
    For,
    If,
    Plan,
    TestGoal,
    While,
    ground_event_literal,
)
from pytest_hricdv.bdi.language.terms import Key, Structure, Variable, is_name, source

from .conditions import Conditions, binds
from .layout import Layout, Numbered, blocks, number, variables_in
from .program import LoopCode, PlanCode, ProgramCode
from .values import Scope, may_bail, values
from .writer import UnsupportedError, Writer

_SOURCE: Key = (False, "source", 1)
FINISH = "finish(a, i, n) if i.open else -n"
"""The last statement is done; most often no other plan goes on."""
FINISH_ACTED = "finish_acted(a, i, n) if i.open else 1 - n"
"""As above, where it is an action, whose outcome comes in the next cycle."""


class BodyWriter:
    """Writes the function for one plan; what a statement does is in :mod:`statements`.

    Args:
        writer: where to.
        program: the program it is part of.
        plan: the plan.
        receivers: the agents that messages can be sent to.
        steady: whether it depends on beliefs alone which plan is selected for such an event.
        forgotten: whether the plan need not be remembered once it has nothing left to do.
    """

    def __init__(
        self,
        writer: Writer,
        program: ProgramCode,
        plan: Plan,
        receivers: frozenset[str],
        steady: bool,
        forgotten: bool,
    ) -> None:
        self._forgotten = forgotten
        self.writer = writer
        self._spins = steady and plan.is_busy_wait
        self.program = program
        self.plan = plan
        self.receivers = receivers
        self.conditions = Conditions(writer, program.table)
        self.layout = Layout(plan)
        self.names = {variable: f"x{place}" for place, variable in enumerate(self.layout.variables)}
        self._values = [*self.names.values(), *(f"l{pc}" for pc in self.layout.loops)]
        binding = (ConditionStatement, For, TestGoal, While)
        self._binds = any(isinstance(statement, binding) for _, statement in self.layout.statements)
        """Whether what variables stand for changes while the body is executed."""
        self.spare = ""
        """What has to be taken off when the activity leaves, if the statement may have had to do without cycles."""
        self._loops: dict[int, LoopCode] = {}
        body = self.layout.body
        self._last = self.layout.end - 1 if body and not blocks(body[-1], 0) else -1
        """The number of the last statement, if no block is around it."""

    def write(self, name: str, bound: frozenset[Variable]) -> PlanCode:
        """Write the function.

        Args:
            name: its name.
            bound: the variables that the trigger and the context bind.

        Raises:
            UnsupportedError: some statement has no compiled form.
        """
        writer, layout = self.writer, self.layout
        scope = {variable: python for variable, python in self.names.items() if variable in bound}
        if layout.loops:
            with writer.block("while True:"):
                self._whole(scope)
        else:
            self._whole(scope)
        lines = writer.take()
        with writer.block(f"def {name}(a, p, b, i, pc, v, n):"):
            if self._values:
                writer.line(f"({', '.join(self._values)},) = v")
            writer.include(lines)
        return PlanCode(self.plan, layout.variables, self._loops, tuple(layout.after), self._last, self._forgotten)

    def _whole(self, scope: Scope) -> None:
        self._block(self.layout.body, 0, scope)
        # A finished plan is taken off in a cycle of its own.
        with self.writer.block(f"if pc == {self.layout.end}:"):
            self.writer.line("return finish(a, i, n - 1) if i.open else 1 - n")

    def _block(self, body: Body, start: int, scope: Scope) -> None:
        from .straight import StraightWriter, straight_run

        numbered = number(body, start)
        while numbered:
            run = straight_run(self, numbered)
            if run:
                straight = StraightWriter(self, run, scope)
                straight.write()
                first, last = run[0][0], run[-1][0]
                with self.writer.block(f"elif {first} <= pc <= {last}:" if first else f"elif pc <= {last}:"):
                    if not straight.write_actions():
                        self._steps(run, scope)
            else:
                run = numbered[:1]
                scope = self._steps(run, scope)
            numbered = numbered[len(run) :]

    def _steps(self, numbered: tuple[Numbered, ...], scope: Scope) -> Scope:
        """Statements one by one."""
        from .statements import write_statement

        for pc, statement in numbered:
            with self.writer.block(f"if pc == {pc}:"):
                after = write_statement(self, pc, statement, scope)
            inside = after
            if isinstance(statement, (For, While)):
                new = binds(statement.condition, scope) if isinstance(statement, For) else ()
                self._loops[pc] = LoopCode(tuple(scope), new)
                inside = {**scope, **self.named(new)}
            for block, first in blocks(statement, pc):
                self._block(block, first, inside)
            if isinstance(statement, If):
                self._check_branches(pc, statement, after)
            scope = after
        return scope

    def _check_branches(self, pc: int, statement: If, scope: Scope) -> None:
        """What only one branch binds must not be looked at afterwards: whether it is bound would depend on the run."""
        inside = {variable for variable in variables_in(statement) if variable not in scope}
        following = [other for number_, other in self.layout.statements if number_ >= self.layout.after[pc] > pc]
        both = set(variables_in(statement.then)) & set(variables_in(statement.otherwise))
        if inside & (both | set(variables_in(tuple(following)))):
            raise UnsupportedError(f"variables bound in only one branch of {statement}")

    def named(self, variables: tuple[Variable, ...]) -> Scope:
        """The Python names of variables."""
        return {variable: self.names[variable] for variable in variables}

    # --- where the activity is

    def save(self, pc: int | str) -> None:
        """Note where the activity is, and what its variables stand for."""
        self.writer.line(f"i.pc = {pc}")
        self.save_values()

    def mark(self, pc: int) -> None:
        """As :meth:`save`, where the statement may have to be left to the interpreter."""
        self.save(pc)
        self.writer.line("i.left = n")

    def mark_for(self, pc: int, *expressions: str) -> None:
        """As :meth:`mark`, if one of these expressions may have no value."""
        if may_bail(*expressions):
            self.mark(pc)

    def stop(self, pc: int) -> None:
        """The statement is done, and something may happen in the next round: do no more than this cycle."""
        after = self.layout.after[pc]
        if after == self.layout.end:
            self.writer.line("return finish(a, i, 0) + 1 - n if i.open else 1 - n")
        else:
            self.save(after)
            self.writer.line("a.intentions.append(i)")
            self.writer.line("return 1 - n")

    def post(self, pc: int, to: str, message: str) -> None:
        """Send a message; go on if nothing can come between."""
        after, line = self.layout.after[pc], self.writer.line
        self.save_values()
        if after == self.layout.end:
            line(f"if a.ahead: return hold(a, i, {pc}, n)")
            line(f"post(a, {to}, {message})")
            self.stop(pc)
        else:
            line(f"n = post_on(a, i, {pc}, {after}, {to}, {message}, n)")
            line("if n <= 0: return n")
            line(f"pc = {after}")

    def go_on(self, pc: int) -> None:
        """The statement is done and its cycle over: suspend, finish, or go on with the next one."""
        after = self.layout.after[pc]
        self.writer.line("n -= 1")
        if after == self.layout.end:
            self.finish(FINISH)
        else:
            self.leave_with(f"pause(a, i, {after})")
            self.writer.line(f"pc = {after}")

    def finish(self, how: str) -> None:
        """The last statement is done."""
        self.writer.line(f"return ({how}){self.spare}")

    def cut_if(self, lost: str, has_plans: bool) -> None:
        """Do what may have lost a belief; if there are plans for that, do no more than this cycle."""
        if has_plans:
            self.writer.line(f"spare = n - 1 if {lost} else 0")
            self.writer.line("if spare: n = 1")
            self.spare = " - spare"
        else:
            self.writer.line(lost)

    def leave_with(self, call: str) -> None:
        """If no cycle is left, leave: ``call`` puts the activity where it has to wait."""
        if self._binds:
            with self.writer.block("if not n:"):
                self.save_values()
                self.writer.line(f"return {call}{self.spare}")
        else:
            self.writer.line(f"if not n: return {call}{self.spare}")

    def save_values(self) -> None:
        """Note what the variables stand for, if that can have changed."""
        if self._binds and self._values:
            self.writer.line(f"i.values = ({', '.join(self._values)},)")

    def call(self, pc: int, trigger: str, args: str, annots: str) -> None:
        """Post a belief event that the activity waits for, and for which there may be a plan."""
        self.save(pc)
        self.writer.line("n -= 1")
        goal = self.goal(trigger, args, annots)
        self.writer.line(f"if n: return enter(a, i, {goal}, n)")
        self.writer.line(f"return pause_at(a, i, {pc}, {goal}){self.spare}")

    def pursue(self, pc: int, literal: Structure, args: str, annots: str) -> None:
        """Post a goal that the activity waits for; with a cycle left, select a plan and begin it."""
        goal = self.goal(self.trigger("+!", literal), args, annots)
        if self._spins:
            self.writer.line(f"return spin(a, i, {goal}, n)")
        else:
            self.save_values()
            self.writer.line(f"return pursue(a, i, {pc}, {goal}, n)")

    def jump(self, targets: tuple[int, ...]) -> None:
        """After a statement that has chosen where to go on."""
        writer = self.writer
        writer.line("n -= 1")
        if self.layout.end in targets:
            with writer.block(f"if pc == {self.layout.end}:"):
                self.finish(FINISH)
        self.leave_with("pause(a, i, pc)")

    # --- what statements are about

    def posted(self, literal: object, scope: Scope) -> tuple[Structure, str, str]:
        """A literal, and the expressions for its arguments and its annotations as its event carries them."""
        if not isinstance(literal, Structure) or literal.annots_tail is not None:
            raise UnsupportedError(f"{literal} is not compiled")
        ready = ground_event_literal(Structure(literal.functor, (), literal.annots, literal.negated))
        if ready is None:
            raise UnsupportedError(f"the annotations of {literal} are not compiled")
        annots = tuple(
            source(str(each.args[0]))
            if isinstance(each, Structure) and each.key == _SOURCE and is_name(each.args[0])
            else each
            for each in ready.annots
        )
        return literal, values(self.writer, literal.args, scope), self.writer.names.constant(annots)

    def goal(self, trigger: str, args: str, annots: str) -> str:
        """What an event is about; one object if it is always the same."""
        known = self.writer.names.objects
        parts = [() if name == "()" else known.get(name) for name in (trigger, args, annots)]
        if None in parts:
            return f"({trigger}, {args}, {annots})"
        return self.writer.names.constant(tuple(parts))

    def trigger(self, sign: str, literal: Structure) -> str:
        """The name of what the agent does on an event."""
        return self.writer.names.constant(self.program.trigger(sign, literal.key))

    def has_plans(self, sign: str, literal: Structure) -> bool:
        """Whether any plan is for an event."""
        return (sign, literal.key) in self.program.relevant

    def solutions(self, formula: Formula, scope: Scope, new: tuple[Variable, ...], every: bool) -> str:
        """A call that gives the values of new variables in the first solution, or the list of all, last first."""
        inner = self.writer.beside()
        name = inner.names.fresh("solutions")
        known = ", ".join(["a", "p", "b", *scope.values()])

        def found(extended: Scope) -> None:
            solution = f"({', '.join(extended[each] for each in new)}{',' if new else ''})"
            inner.line(f"solutions.append({solution})" if every else f"return {solution}")

        with inner.block(f"def {name}({known}):"):
            if every:
                inner.line("solutions = []")
            Conditions(inner, self.program.table).require((formula,), scope, found, every)
            inner.line("return solutions[::-1]" if every else "return None")
        inner.functions.extend(inner.lines)
        return f"{name}({known})"
