"""Contexts and other conditions as Python: tests where they bind nothing, nested loops over beliefs where they do."""

from __future__ import annotations

from collections.abc import Callable

from pytest_hricdv.bdi.language.formulas import And, Comparison, Formula, Not, Or
from pytest_hricdv.bdi.language.syntax_tree import variables_of
from pytest_hricdv.bdi.language.terms import Arithmetic, Number, Structure, Term, Variable, is_name
from pytest_hricdv.bdi.language.terms import source as source_of

from .layout import variables_in
from .program import proposition
from .values import Scope, equality, number, value, values
from .writer import UnsupportedError, Writer

Then = Callable[[Scope], None]
"""Writes what is to be done where a condition holds, with the variables it has bound."""
_ORDERED = {"<": "<", ">": ">", "<=": "<=", ">=": ">="}


class Conditions:
    """Writes conditions.

    Args:
        writer: where to.
        table: gives the Python name of the table of a predicate with arguments.
    """

    def __init__(self, writer: Writer, table: Callable[[Structure], str]) -> None:
        self._writer = writer
        self._table = table

    def require(self, parts: tuple[Formula, ...], scope: Scope, then: Then, every: bool) -> None:
        """Write code that goes on with ``then`` for every solution, in the interpreter's order.

        Args:
            parts: all of them have to hold.
            scope: the variables bound before.
            then: must leave the function if only the first solution counts.
            every: whether all solutions count: a condition that holds in two ways then counts twice.

        Raises:
            UnsupportedError: there is no compiled form.
        """
        if not parts:
            then(scope)
            return
        part, rest = parts[0], parts[1:]

        def go_on(extended: Scope) -> None:
            self.require(rest, extended, then, every)

        if isinstance(part, And):
            self.require((*part.parts, *rest), scope, then, every)
        elif isinstance(part, Or) and every:
            raise UnsupportedError("alternatives of which each counts")
        elif isinstance(part, Comparison) and part.operator == "=" and _is_unbound(part.left, scope):
            self._assign(part, scope, go_on)
        elif isinstance(part, Structure) and not part.ground:
            self._match(part, scope, go_on, every)
        else:
            tests = [self.test(part, scope)]
            while rest and isinstance(rest[0], Structure) and rest[0].ground:
                tests.append(self.test(rest[0], scope))
                rest = rest[1:]
            with self._writer.block(f"if {' and '.join(tests)}:"):
                go_on(scope)

    def test(self, formula: Formula, scope: Scope) -> str:
        """An expression for whether a formula holds that binds nothing for what comes after it.

        Raises:
            UnsupportedError: there is no compiled form.
        """
        if isinstance(formula, Comparison):
            return self._comparison(formula, scope)
        if isinstance(formula, Not):
            if variables_of(formula.part) <= scope.keys():
                return f"not {self.test(formula.part, scope)}"
            return f"not {self._exists(formula.part, scope)}"
        if isinstance(formula, (And, Or)):
            joint = " and " if isinstance(formula, And) else " or "
            return f"({joint.join(self.test(part, scope) for part in formula.parts)})"
        if isinstance(formula, Structure) and formula.ground:
            return self._believed(formula)
        if isinstance(formula, Structure) and variables_of(formula) <= scope.keys():
            return self._exists(formula, scope)
        raise UnsupportedError(f"{formula} is not compiled as a test")

    def _believed(self, literal: Structure) -> str:
        """A literal without variables."""
        if literal.functor in ("true", "false"):
            if literal.functor == "true" and is_name(literal):
                return "True"
            raise UnsupportedError(f"{literal} has a meaning of its own")
        if literal.args:
            store, slot = self._table(literal), values(self._writer, literal.args, {})
        else:
            store, slot = "p", repr(proposition(literal))
        if not literal.annots:
            return f"{slot} in {store}"
        source = source_pattern(literal)
        assert source is not None
        return f"({self._writer.names.constant(named_source(source))} in {store}.get({slot}, ()))"

    def _exists(self, formula: Formula, scope: Scope) -> str:
        """A call of a function of its own, so that what is bound inside is not bound outside."""
        if isinstance(formula, Structure) and _is_any(formula, scope):
            return self._table(formula)
        inner = self._writer.beside()
        name = inner.names.fresh("exists")
        known = [scope[variable] for variable in sorted(variables_of(formula) & scope.keys())]
        head = ", ".join(["a", "p", "b", *known])
        with inner.block(f"def {name}({head}):"):
            Conditions(inner, self._table).require((formula,), scope, lambda _: inner.line("return True"), False)
            inner.line("return False")
        inner.functions.extend(inner.lines)
        return f"{name}({head})"

    def _assign(self, comparison: Comparison, scope: Scope, then: Then) -> None:
        variable = comparison.left
        assert isinstance(variable, Variable)
        name = self._writer.names.fresh("v")
        self._writer.line(f"{name} = {value(self._writer, comparison.right, scope)}")
        then({**scope, variable: name})

    def _match(self, literal: Structure, scope: Scope, then: Then, every: bool) -> None:
        """A literal that binds variables, or that has to be unified with each belief."""
        writer = self._writer
        source = source_pattern(literal)
        extended = dict(scope)
        held = writer.names.fresh("s")
        if literal.args:
            names, tests = self.unpack(literal.args, extended)
            table = self._table(literal)
            if source is None and not every:
                # Most often there is but one, and which comes first makes no difference.
                writer.line(f"t = {table}")
                head = f"for ({', '.join(names)},) in t if len(t) == 1 else reversed(t):"
            else:
                head = f"for ({', '.join(names)},), {held} in reversed({table}.items()):"
        else:
            tests = []
            head = f"for {held} in believed(p, {proposition(literal)!r}):"
        with writer.block(head):
            self._with_tests(tests, lambda: self._with_source(source, held, extended, then))

    def unpack(self, args: tuple[Term, ...], scope: Scope) -> tuple[list[str], list[str]]:
        """Python names for arguments, added to the scope where they bind a variable, and the tests for the rest."""
        names: list[str] = []
        tests: list[str] = []
        for arg in args:
            name = self._writer.names.fresh("v")
            names.append(name)
            if isinstance(arg, Variable) and arg not in scope:
                scope[arg] = name
            else:
                tests.append(equality(self._writer, name, arg, scope))
        return names, tests

    def _with_tests(self, tests: list[str], inside: Callable[[], None]) -> None:
        if tests:
            with self._writer.block(f"if {' and '.join(tests)}:"):
                inside()
        else:
            inside()

    def _with_source(self, source: Term | None, held: str, scope: Scope, then: Then) -> None:
        writer = self._writer
        if source is None:
            then(scope)
        elif isinstance(source, Variable):
            name = writer.names.fresh("v")
            with writer.block(f"for {name} in sources({held}):"):
                if source in scope:
                    with writer.block(f"if same({scope[source]}, {name}):"):
                        then(scope)
                else:
                    then({**scope, source: name})
        else:
            with writer.block(f"if {writer.names.constant(named_source(source))} in {held}:"):
                then(scope)

    def _comparison(self, comparison: Comparison, scope: Scope) -> str:
        operator, left, right = comparison.operator, comparison.left, comparison.right
        writer = self._writer
        if operator in _ORDERED:
            return f"({number(writer, left, scope)} {_ORDERED[operator]} {number(writer, right, scope)})"
        sides = [_plain_value(writer, side, scope) for side in (left, right)]
        if operator in ("==", "\\=="):
            return f"({sides[0]} {'==' if operator == '==' else '!='} {sides[1]})"
        if operator == "=":
            return f"same({sides[0]}, {sides[1]})"
        raise UnsupportedError(f"{comparison} is not compiled")


def source_pattern(literal: Structure) -> Term | None:
    """What the only annotation of a literal asks of a source: an agent's name, or a variable; None without one.

    Raises:
        UnsupportedError: other annotations.
    """
    if not literal.annots and literal.annots_tail is None:
        return None
    if len(literal.annots) == 1 and literal.annots_tail is None:
        annot = literal.annots[0]
        if isinstance(annot, Structure) and annot.functor == "source" and len(annot.args) == 1 and not annot.annots:
            asked = annot.args[0]
            if isinstance(asked, Variable) or is_name(asked):
                return asked
    raise UnsupportedError(f"the annotations of {literal} are not compiled")


def named_source(name: Term) -> Structure:
    """The annotation for a source, the very object that received messages get: it is compared in no time."""
    assert isinstance(name, Structure)
    return source_of(name.functor)


def _plain_value(writer: Writer, term: Term, scope: Scope) -> str:
    """A side of an equation: numbers need not be terms to be compared."""
    return number(writer, term, scope) if isinstance(term, (Arithmetic, Number)) else value(writer, term, scope)


def _is_unbound(term: Term, scope: Scope) -> bool:
    return isinstance(term, Variable) and term not in scope


def binds(formula: Formula, scope: Scope) -> tuple[Variable, ...]:
    """The variables that a condition binds, in order; for alternatives none: their bindings are not compiled."""
    if isinstance(formula, And):
        found: dict[Variable, str] = {}
        for part in formula.parts:
            found.update(dict.fromkeys(binds(part, {**scope, **found}), ""))
        return tuple(found)
    unified: object = formula if isinstance(formula, Structure) else ()
    if isinstance(formula, Comparison) and formula.operator == "=":
        unified = formula.left
    return tuple(variable for variable in variables_in(unified) if variable not in scope)


def _is_any(literal: Structure, scope: Scope) -> bool:
    """Whether any belief of its predicate unifies with a literal."""
    unbound = {arg for arg in literal.args if isinstance(arg, Variable) and arg not in scope}
    is_plain = not literal.annots and literal.annots_tail is None
    return is_plain and bool(unbound) and len(unbound) == len(literal.args)
