"""Finding the first applicable plan for an event, as a Python function for each kind of event."""

from __future__ import annotations

from itertools import groupby

from pytest_hricdv.bdi.language.formulas import And, Formula
from pytest_hricdv.bdi.language.syntax import EventKey, Plan
from pytest_hricdv.bdi.language.terms import Structure, Variable

from ..spinning import is_steady
from .bodies import BodyWriter
from .conditions import Conditions, named_source, source_pattern
from .program import PlanCode, ProgramCode
from .values import Scope, equality, may_bail, trusting
from .writer import Names, UnsupportedError, Writer


class SelectionWriter:
    """Writes the functions for the events of a program and for the plans that are for them.

    Args:
        program: the program; its triggers are added to.
        names: the objects named by its code.
        receivers: the agents that messages can be sent to.
        forgotten: the labels of the plans that need not be remembered once they have nothing left to do.
    """

    def __init__(
        self, program: ProgramCode, names: Names, receivers: frozenset[str], forgotten: frozenset[str]
    ) -> None:
        self._forgotten = forgotten
        self._program = program
        self._names = names
        self._receivers = receivers
        self.functions: list[str] = []
        self.plans: dict[str, PlanCode] = {}
        """The code of the plans that have one, by the name of their function."""

    def write(self, name: str, event: EventKey, plans: tuple[Plan, ...]) -> None:
        """Write the function that selects among plans for one event, in their order."""
        sign, (_, _, arity) = event
        writer = Writer(self._names, self.functions)
        self._steady = is_steady(plans)
        self._plans(writer, plans)
        writer.line("return None")
        lines = writer.take()
        with writer.block(f"def {name}(a, p, b, args, annots):"):
            if arity:
                writer.line(f"({', '.join(f'e{place}' for place in range(arity))},) = args")
            if may_bail(*lines):
                with writer.block("try:"):
                    writer.include([trusting(line)[0] for line in lines])
                # What is no number has no arithmetic; no plan for a goal is left to the interpreter, too.
                with writer.block("except (BailError, TypeError):"):
                    writer.line("return None" if sign == "+!" else "bail()")
            else:
                writer.include(lines)
        self.functions.extend(writer.lines)

    def _plans(self, writer: Writer, plans: tuple[Plan, ...]) -> None:
        """Write the search among plans in their order; those in a row that begin with the same test share it."""
        for test, group in groupby(plans, _first_test):
            if test is None:
                self._in_order(writer, [(plan, (() if plan.context is None else (plan.context,))) for plan in group])
                continue
            rest = [(plan, plan.context.parts[1:]) for plan in group if isinstance(plan.context, And)]
            with writer.block(f"if {Conditions(writer, self._program.table).test(test, {})}:"):
                self._in_order(writer, rest)

    def _in_order(self, writer: Writer, plans: list[tuple[Plan, tuple[Formula, ...]]]) -> None:
        for plan, context in plans:
            try:
                with writer.attempt():
                    self._plan(writer, plan, context)
            except UnsupportedError:
                # Its trigger or context has no compiled form: whether it is applicable is not known here.
                writer.line("bail()")
                return

    def _plan(self, writer: Writer, plan: Plan, context: tuple[Formula, ...]) -> None:
        literal = plan.trigger.literal
        if not isinstance(literal, Structure):
            raise UnsupportedError(f"{plan.trigger} is for any event")
        scope, tests = self._trigger(writer, literal)
        source = source_pattern(literal)
        if isinstance(source, Variable):
            name = writer.names.fresh("v")
            writer.line(f"{name} = first_source(annots)")
            tests.append(f"{name} is not None")
            if source in scope:
                tests.append(f"same({scope[source]}, {name})")
            scope.setdefault(source, name)
        elif source is not None:
            tests.append(f"{writer.names.constant(named_source(source))} in annots")
        if tests:
            with writer.block(f"if {' and '.join(tests)}:"):
                self._context(writer, plan, context, scope)
        else:
            self._context(writer, plan, context, scope)

    def _trigger(self, writer: Writer, literal: Structure) -> tuple[Scope, list[str]]:
        """The variables that the arguments of an event bind, and the tests they have to pass."""
        scope: Scope = {}
        tests: list[str] = []
        for place, arg in enumerate(literal.args):
            if isinstance(arg, Variable) and arg not in scope:
                scope[arg] = f"e{place}"
            else:
                tests.append(equality(writer, f"e{place}", arg, scope))
        return scope, tests

    def _context(self, writer: Writer, plan: Plan, context: tuple[Formula, ...], scope: Scope) -> None:
        def select(extended: Scope) -> None:
            code = self._code(plan, frozenset(extended))
            if code is None:
                writer.line("bail()")
                return
            name, variables, loops = code
            values = [extended.get(variable, "None") for variable in variables] + ["None"] * loops
            found = (
                f"{name}, ({', '.join(values)},)" if values else self._names.constant((self._names.objects[name], ()))
            )
            writer.line(f"return {found}")

        Conditions(writer, self._program.table).require(context, scope, select, every=False)

    def _body(self, writer: Writer, plan: Plan) -> BodyWriter:
        forgotten = plan.label in self._forgotten
        return BodyWriter(writer, self._program, plan, self._receivers, self._steady, forgotten)

    def _code(self, plan: Plan, bound: frozenset[Variable]) -> tuple[str, tuple[Variable, ...], int] | None:
        """The name of a plan's code, its variables and the number of its loops; None if it has no compiled form."""
        if plan.atomic:
            return None
        writer = Writer(self._names, [])
        name = f"plan{len(self.plans)}"
        try:
            code = self._body(writer, plan).write(name, bound)
        except UnsupportedError:
            return None
        self.functions += writer.functions + writer.lines
        self.plans[name] = code
        return self._names.constant(code), code.variables, len(code.loops)


def _first_test(plan: Plan) -> Structure | None:
    """What a plan for any event of its kind tests first of all, if that is a proposition."""
    literal, context = plan.trigger.literal, plan.context
    if not isinstance(literal, Structure) or literal.args or literal.annots or literal.annots_tail is not None:
        return None
    if not isinstance(context, And) or not isinstance(context.parts[0], Structure):
        return None
    first = context.parts[0]
    is_plain = not first.args and not first.annots and first.annots_tail is None
    return first if is_plain and first.functor not in ("true", "false") else None
