"""`build_model` makes the `AgentModel` of an agent's program, which lint checks; `location_of` finds names in sources.

`lint` and the module `generate.model` call it for each agent of a project.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

from pytest_hricdv.bdi.language import syntax
from pytest_hricdv.bdi.language.errors import Location
from pytest_hricdv.bdi.language.parser import SourceText, read_source
from pytest_hricdv.bdi.language.syntax_tree import children
from pytest_hricdv.bdi.language.terms import (
    AnnotatedVariable,
    Arithmetic,
    Call,
    ListTerm,
    String,
    Structure,
    Term,
    Variable,
)
from pytest_hricdv.bdi.lint.model import SELF, Addition, AgentModel, Mention, SentMessage, sources_in

_HIDDEN = re.compile(r"//[^\n]*|/\*[\s\S]*?\*/|\"[^\"\\]*(?:\\.[^\"\\]*)*\"")
"""Comments and strings, in which names are not searched for."""
FORMULA_ARGUMENTS = {
    ".findall": 1,
    ".setof": 1,
    ".count": 0,
    ".eval": 1,
    ".belief": 0,
    ".wait": 0,
}
"""The index of the argument of an internal action that is a condition."""


@lru_cache(maxsize=64)  # each finding asks for its file again; most projects have fewer files
def _source_of(file: str) -> SourceText:
    path = Path(file)
    return read_source(path) if path.is_file() else SourceText("")


def text_of(file: str) -> str:
    """The text of a source file; empty if there is no such file."""
    return _source_of(file).text


def encoding_fault(file: str) -> str:
    """The error of a source file that is not UTF-8, with its place; else empty."""
    return _source_of(file).not_utf8


def files_of(agent: AgentModel) -> list[str]:
    """The agent's source file, and those that it includes."""
    return [agent.file, *(plan.location.file for plan in agent.plans), *(rule.location.file for rule in agent.rules)]


@lru_cache(maxsize=64)
def _code_of(file: str) -> str:
    """The text with comments and strings replaced by spaces, so that places stay the same."""
    return _HIDDEN.sub(lambda hidden: re.sub(r"[^\n]", " ", hidden[0]), text_of(file))


@lru_cache(maxsize=64)
def _line_starts(file: str) -> tuple[int, ...]:
    text = text_of(file)
    return (0, *(newline.end() for newline in re.finditer("\n", text)))


def location_of(name: str, start: Location, skip: str = "") -> Location:
    """The place of a name after ``start`` and after the name ``skip``; ``start`` if it does not occur."""
    code, starts = _code_of(start.file), _line_starts(start.file)
    if start.line > len(starts):
        return start
    offset = starts[start.line - 1] + start.column - 1
    if skip:
        skipped = _word(skip).search(code, offset)
        offset = skipped.end() if skipped else offset
    match = _word(name).search(code, offset)
    return start if match is None else _location(start.file, match.start())


def declaration_of(percept: str, file: str) -> Location:
    """Where a remark of a source declares a percept; the beginning of the source if none does."""
    for remark in re.finditer(r"//\s*lint:\s*percepts\b[^\n]*", text_of(file)):
        name = re.search(rf"(?<!\w){re.escape(percept)}(?!\w)", remark[0])
        if name is not None:
            return _location(file, remark.start() + name.start())
    return Location(file, 1, 1)


_ANONYMOUS = re.compile(r"(?<!\w)_+[A-Za-z]\w*")
_CLAUSE_END = re.compile(r"\.(?=\s|$)")


def repeats_of_anonymous(file: str) -> Iterator[tuple[Location, str]]:
    """Names of the form ``_name`` that occur twice in a clause, with the location of the second one."""
    code, start = _code_of(file), 0
    for end in (*(match.end() for match in _CLAUSE_END.finditer(code)), len(code)):
        places: dict[str, list[int]] = {}
        for match in _ANONYMOUS.finditer(code, start, end):
            places.setdefault(match[0], []).append(match.start())
        for name, offsets in places.items():
            if len(offsets) > 1:
                yield _location(file, offsets[1]), f"{name} is another variable than the {name} before it"
        start = end


def _location(file: str, offset: int) -> Location:
    before = text_of(file)[:offset]
    return Location(file, before.count("\n") + 1, offset - (before.rfind("\n") + 1) + 1)


@lru_cache(maxsize=1024)
def _word(name: str) -> re.Pattern[str]:
    return re.compile(rf"(?<![\w.]){re.escape(name)}(?!\w)")


def clear_cache() -> None:
    """Clear the cache of texts, so that changed files are read again."""
    for cached in (_source_of, _code_of, _line_starts):
        cached.cache_clear()


def build_model(name: str, file: str, program: syntax.Program) -> AgentModel:
    """The model of an agent; the program includes the beliefs and goals of the project's options."""
    model = AgentModel(name, file, program.plans, tuple(b for b in program.beliefs if isinstance(b, syntax.Rule)))
    start = Location(file, 1, 1)
    for belief in program.beliefs:
        if isinstance(belief, syntax.Rule):
            model.additions.append(Addition(belief.head.key, None, belief.location, False))
            _formula(model, belief.body, belief.location, belief.head.functor, None)
        else:
            place = location_of(belief.functor, start)
            model.additions += _add(belief, place, False)
    for goal in program.goals:
        model.goals.append(Mention(goal, location_of(goal.functor, start)))
    for plan in program.plans:
        _plan(model, plan)
    return model


def _plan(model: AgentModel, plan: syntax.Plan) -> None:
    trigger = plan.trigger
    literal = trigger.literal
    name = literal.functor if isinstance(literal, Structure) else ""
    if isinstance(literal, Structure) and trigger.sign in ("+", "-"):
        model.tests.append(Mention(literal, location_of(name, plan.location), plan))
    if plan.context is not None:
        _formula(model, plan.context, plan.location, name, plan)
    _body(model, plan.body, plan)


def _body(model: AgentModel, body: syntax.Body, plan: syntax.Plan) -> None:
    for statement in body:
        _statement(model, statement, plan)
        for block in ("then", "otherwise", "body"):
            _body(model, getattr(statement, block, ()), plan)
        for branch in getattr(statement, "branches", ()):
            _body(model, branch, plan)


def _statement(model: AgentModel, statement: syntax.Statement, plan: syntax.Plan) -> None:
    place = statement.location
    if isinstance(statement, syntax.AchievementGoal):
        if isinstance(statement.literal, Structure):
            model.goals.append(Mention(statement.literal, location_of(statement.literal.functor, place), plan))
    elif isinstance(statement, syntax.BeliefUpdate):
        _believe(model, statement, plan)
    elif isinstance(statement, syntax.InternalActionCall):
        _call(model, statement.call, place, plan)
    elif isinstance(statement, (syntax.TestGoal, syntax.ConditionStatement)):
        _formula(model, statement.formula, place, "", plan)
    elif isinstance(statement, (syntax.If, syntax.While, syntax.For)):
        _formula(model, statement.condition, place, "", plan)


def _believe(model: AgentModel, statement: syntax.BeliefUpdate, plan: syntax.Plan) -> None:
    literal, place = statement.literal, statement.location
    if not isinstance(literal, Structure):
        if statement.sign != "-":
            model.additions.append(Addition(None, None if _has_source_annotation(literal) else SELF, place))
        return
    place = location_of(literal.functor, place)
    if statement.sign == "-":
        model.deletions.append(Mention(literal, place, plan))
    else:
        model.additions += _add(literal, place, True)


def _has_source_annotation(literal: Term) -> bool:
    """Whether a variable has annotations, which may name a source."""
    return isinstance(literal, AnnotatedVariable) and bool(literal.annots)


def _add(literal: Structure, place: Location, during_run: bool) -> list[Addition]:
    return [Addition(literal.key, source, place, during_run) for source in sources_in(literal) or {SELF}]


def _formula(model: AgentModel, formula: object, place: Location, skip: str, plan: syntax.Plan | None) -> None:
    """Collect the tests in a condition; ``skip`` is a name between ``place`` and the condition."""
    if isinstance(formula, Structure):
        if formula.functor not in ("true", "false"):
            model.tests.append(Mention(formula, location_of(formula.functor, place, skip), plan))
        _calls(model, formula.args, place, plan)
    elif isinstance(formula, (syntax.And, syntax.Or, syntax.Not)):
        for part in children(formula):
            for operand in part if isinstance(part, tuple) else (part,):
                _formula(model, operand, place, skip, plan)
    elif isinstance(formula, syntax.Comparison):
        _calls(model, (formula.left, formula.right), place, plan)
    elif isinstance(formula, Call):
        _call(model, formula, place, plan)


def _calls(model: AgentModel, terms: object, place: Location, plan: syntax.Plan | None) -> None:
    """Collect the functions in terms."""
    pending = [terms]
    while pending:
        part = pending.pop()
        if isinstance(part, Call):
            _call(model, part, place, plan)
        elif isinstance(part, (tuple, Structure, ListTerm, Arithmetic)):
            pending.extend(children(part))


def _call(model: AgentModel, call: Call, place: Location, plan: syntax.Plan | None) -> None:
    model.actions.add(call.name)
    index = FORMULA_ARGUMENTS.get(call.name)
    for position, argument in enumerate(call.args):
        if position == index or isinstance(argument, (syntax.And, syntax.Or, syntax.Not, syntax.Comparison, Call)):
            _formula(model, argument, call.location, "", plan)
    if call.name == ".abolish" and isinstance(call.args[0], Structure):
        literal = call.args[0]
        # It removes the belief of every source.
        model.deletions.append(Mention(_from_any_source(literal), location_of(literal.functor, call.location), plan))
    elif call.name in (".send", ".broadcast"):
        _message(model, call)


def _from_any_source(literal: Structure) -> Structure:
    return literal.with_annotations((*literal.annots, Structure("source", (Variable("_AnySource"),))))


def _message(model: AgentModel, call: Call) -> None:
    to, force, content = call.args[:3] if call.name == ".send" else (None, *call.args[:2])
    receivers: tuple[str, ...] | None = None
    if isinstance(to, (Structure, String, ListTerm)):
        names = [_name(item) for item in (to.items if isinstance(to, ListTerm) else (to,))]
        receivers = tuple(name for name in names if name) if all(names) else None
    answered = call.name == ".send" and len(call.args) > 3
    broadcast = call.name == ".broadcast"
    model.sent.append(SentMessage(_name(force), receivers, content, call.location, answered, broadcast))  # type: ignore[arg-type]


def _name(term: object) -> str:
    if isinstance(term, String):
        return term.value
    return term.functor if isinstance(term, Structure) and not term.args else ""
