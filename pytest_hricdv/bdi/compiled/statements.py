"""What each kind of statement becomes in Python."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from pytest_hricdv.bdi.language.formulas import Formula
from pytest_hricdv.bdi.language.syntax import (
    AchievementGoal,
    BeliefUpdate,
    ConditionStatement,
    ExternalAction,
    For,
    If,
    InternalActionCall,
    Statement,
    TestGoal,
    While,
)
from pytest_hricdv.bdi.language.terms import SOURCE_PERCEPT, Call, Number, String, Structure, is_ground, is_name

from ..intentions import duration
from .bodies import FINISH, FINISH_ACTED, BodyWriter
from .conditions import binds
from .layout import blocks, variables_in
from .program import proposition
from .values import Scope, number, value, values
from .writer import UnsupportedError

_FORCES = frozenset({"tell", "achieve"})


def write_statement(body: BodyWriter, pc: int, statement: Statement, scope: Scope) -> Scope:
    """Write a statement; the variables bound after it.

    Raises:
        UnsupportedError: there is no compiled form.
    """
    return _WRITE[type(statement)](body, pc, statement, scope)


def _achieve(body: BodyWriter, pc: int, statement: AchievementGoal, scope: Scope) -> Scope:
    literal, args, annots = body.posted(statement.literal, scope)
    body.mark_for(pc, args)
    if statement.new_intention:
        goal = body.goal(body.trigger("+!", literal), args, annots)
        body.writer.line(f"a.events.append(({goal}, None))")
        body.stop(pc)
    else:
        body.pursue(pc, literal, args, annots)
    return scope


def _believe(body: BodyWriter, pc: int, statement: BeliefUpdate, scope: Scope) -> Scope:
    literal, args, annots = body.posted(statement.literal, scope)
    if SOURCE_PERCEPT in literal.annots or statement.sign == "++":
        raise UnsupportedError(f"{statement} is not compiled")
    writer, sign = body.writer, statement.sign
    if not literal.args:
        store, slot = "p", repr(proposition(literal))
    else:
        body.mark_for(pc, args)
        writer.line(f"args = {args}")
        store, slot, args = body.program.table(literal), "args", "args"
    if sign == "-+" and literal.args and not body.has_plans("-", literal):
        writer.line(f"new = replace(a, {store}, args, {annots})")
    else:
        if sign == "-+":
            lost = f"displace(a, {store}, {'None' if literal.args else slot}, {annots}, {body.trigger('-', literal)})"
            body.cut_if(lost, body.has_plans("-", literal))
        writer.line(f"new = {'remove' if sign == '-' else 'add'}(a, {store}, {slot}, {annots})")
    event_sign = "-" if sign == "-" else "+"
    _wait_for_event(body, pc, event_sign, literal, args)
    body.spare = ""
    return scope


def _wait_for_event(body: BodyWriter, pc: int, sign: str, literal: Structure, args: str) -> None:
    """After a change of beliefs, which has an event if ``new`` is not None."""
    writer = body.writer
    event, after = body.trigger(sign, literal), body.layout.after[pc]
    if body.has_plans(sign, literal):
        with writer.block("if new is None:"):
            body.go_on(pc)
        with writer.block("else:"):
            body.call(pc, event, args, "new")
        return
    # The activity waits for an event that no plan is for: it goes on in the next cycle, and only then is it over.
    writer.line("n -= 1")
    if after == body.layout.end:
        with writer.block("if new is None:"):
            body.finish(FINISH)
    body.leave_with(f"pause_for(a, i, {pc}, {after}, {event}, {args}, new)")
    writer.line(f"pc = {after}")


def _act(body: BodyWriter, pc: int, statement: ExternalAction, scope: Scope) -> Scope:
    action, writer, names = statement.action, body.writer, body.writer.names
    if not isinstance(action, Structure):
        raise UnsupportedError(f"{statement} is not compiled")
    done = value(writer, action, scope)
    if not action.ground:
        body.mark_for(pc, done)
        writer.line(f"action = {done}")
        done = "action"
    where = f"{names.constant(body.plan)}, {names.constant(statement)}"
    body.save_values()
    writer.line(f"n = act(a, i, {pc}, {done}, {where}, n)")
    writer.line("if n <= 0: return n")
    after = body.layout.after[pc]
    if after == body.layout.end:
        body.finish(FINISH_ACTED)
    else:
        writer.line(f"pc = {after}")
    return scope


def _check(body: BodyWriter, pc: int, statement: ConditionStatement, scope: Scope) -> Scope:
    return _first(body, pc, statement.formula, scope)


def _test(body: BodyWriter, pc: int, statement: TestGoal, scope: Scope) -> Scope:
    return _first(body, pc, statement.formula, scope)


def _first(body: BodyWriter, pc: int, formula: Formula, scope: Scope) -> Scope:
    """A condition that has to hold; if it does not, the interpreter makes the statement fail."""
    body.mark(pc)
    new = binds(formula, scope)
    if not new:
        with body.writer.block(f"if not {body.conditions.test(formula, scope)}:"):
            body.writer.line("bail()")
    else:
        body.writer.line(f"found = {body.solutions(formula, scope, new, every=False)}")
        with body.writer.block("if found is None:"):
            body.writer.line("bail()")
        body.writer.line(f"({', '.join(body.names[each] for each in new)},) = found")
    body.go_on(pc)
    return {**scope, **body.named(new)}


def _if(body: BodyWriter, pc: int, statement: If, scope: Scope) -> Scope:
    if binds(statement.condition, scope):
        raise UnsupportedError(f"{statement.condition} binds variables")
    (_, then), (_, otherwise) = blocks(statement, pc)
    after = body.layout.after[pc]
    targets = (then if statement.then else after, otherwise if statement.otherwise else after)
    test = body.conditions.test(statement.condition, scope)
    body.mark_for(pc, test)
    body.writer.line(f"pc = {targets[0]} if {test} else {targets[1]}")
    body.jump(targets)
    return scope


def _while(body: BodyWriter, pc: int, statement: While, scope: Scope) -> Scope:
    if binds(statement.condition, scope):
        raise UnsupportedError(f"{statement.condition} binds variables")
    body.mark(pc)
    inside = pc + 1 if statement.body else pc
    _reset(body, statement, scope)
    with body.writer.block(f"if {body.conditions.test(statement.condition, scope)}:"):
        body.writer.line(f"l{pc} = True")
        body.writer.line(f"pc = {inside}")
    with body.writer.block("else:"):
        _leave_loop(body, pc)
    body.jump((inside, body.layout.after[pc]))
    return scope


def _for(body: BodyWriter, pc: int, statement: For, scope: Scope) -> Scope:
    new = binds(statement.condition, scope)
    body.mark(pc)
    inside = pc + 1 if statement.body else pc
    with body.writer.block(f"if l{pc} is None:"):
        body.writer.line(f"l{pc} = {body.solutions(statement.condition, scope, new, every=True)}")
    _reset(body, statement, scope)
    with body.writer.block(f"if l{pc}:"):
        bound = f"({', '.join(body.names[each] for each in new)},) = " if new else ""
        body.writer.line(f"{bound}l{pc}.pop()")
        body.writer.line(f"pc = {inside}")
    with body.writer.block("else:"):
        _leave_loop(body, pc)
    body.jump((inside, body.layout.after[pc]))
    return scope


def _reset(body: BodyWriter, statement: For | While, scope: Scope) -> None:
    """What was bound in a loop is bound neither in its next round nor after it."""
    for variable in variables_in(statement):
        if variable not in scope:
            body.writer.line(f"{body.names[variable]} = None")


def _leave_loop(body: BodyWriter, pc: int) -> None:
    body.writer.line(f"l{pc} = None")
    body.writer.line(f"pc = {body.layout.after[pc]}")


def _internal(body: BodyWriter, pc: int, statement: InternalActionCall, scope: Scope) -> Scope:
    call = statement.call
    write = _INTERNAL.get((call.name, len(call.args))) or _INTERNAL.get((call.name, -1))
    if write is None:
        raise UnsupportedError(f"{call} is not compiled")
    if call.name != ".send" or not is_ground(call.args[2]):  # type: ignore[arg-type]
        body.mark(pc)
    write(body, pc, call, scope)
    return scope


def _print(body: BodyWriter, pc: int, call: Call, scope: Scope) -> None:
    body.writer.line(printed(body, call, scope))
    body.go_on(pc)


def printed(body: BodyWriter, call: Call, scope: Scope) -> str:
    """What prints the arguments of a call."""
    parts = [_text(body, arg, scope) for arg in call.args]
    return f"a.run.print(a.name, {' + '.join(parts) or repr('')})"


def _text(body: BodyWriter, arg: Any, scope: Scope) -> str:
    if isinstance(arg, String):
        return body.writer.names.constant(arg.value)
    if isinstance(arg, Structure) and arg.ground:
        return body.writer.names.constant(str(arg))
    return f"shown({value(body.writer, arg, scope)})"


def _send(body: BodyWriter, pc: int, call: Call, scope: Scope) -> None:
    receiver, force, content = call.args
    if not isinstance(receiver, Structure) or not is_name(receiver) or receiver.functor not in body.receivers:
        raise UnsupportedError(f"{receiver} is not an agent known beforehand")
    if not isinstance(force, Structure) or not is_name(force) or force.functor not in _FORCES:
        raise UnsupportedError(f"messages of force {force} are not compiled")
    told, to = force.functor == "tell", repr(receiver.functor)
    if isinstance(content, Structure) and content.ground:
        body.program.letters.append((receiver.functor, told, content))
        message = f"a.letters[{len(body.program.letters) - 1}]"
    else:
        sent = value(body.writer, content, scope)  # type: ignore[arg-type]
        body.program.forms.append((receiver.functor, told, content if isinstance(content, Structure) else None))
        form = len(body.program.forms) - 1
        if isinstance(content, Structure):
            message = f"filled(a, {form}, {values(body.writer, content.args, scope)})"
        else:
            message = f"lettered(a, {force.functor!r}, {form}, {sent})"
    body.post(pc, to, message)


def _abolish(body: BodyWriter, pc: int, call: Call, scope: Scope) -> None:
    pattern = call.args[0]
    if not isinstance(pattern, Structure) or pattern.annots or pattern.annots_tail is not None:
        raise UnsupportedError(f"{call} is not compiled")
    writer, trigger = body.writer, body.trigger("-", pattern)
    store, slots = "p", f"[{proposition(pattern)!r}]"
    if pattern.args:
        store, slots = body.program.table(pattern), "slots"
        names, tests = body.conditions.unpack(pattern.args, dict(scope))
        writer.line("slots = []")
        with writer.block(f"for args in reversed({store}):"):
            writer.line(f"({', '.join(names)},) = args")
            with writer.block(f"if {' and '.join(tests) or 'True'}:"):
                writer.line("slots.append(args)")
    with writer.block(f"if abolish(a, {store}, {slots}, {trigger}):"):
        body.stop(pc)
    body.go_on(pc)


def _wait(body: BodyWriter, pc: int, call: Call, scope: Scope) -> None:
    wait_ms = call.args[0]
    if isinstance(wait_ms, Number) and math.isfinite(wait_ms):
        ticks = repr(float(duration(wait_ms)))
    else:
        ticks = f"duration({number(body.writer, wait_ms, scope)})"  # type: ignore[arg-type]
    body.writer.line(f"return wait(a, i, {ticks}, n)")


_INTERNAL: dict[tuple[str, int], Callable[[BodyWriter, int, Call, Scope], None]] = {
    (".print", -1): _print,
    (".println", -1): _print,
    (".send", 3): _send,
    (".abolish", 1): _abolish,
    (".wait", 1): _wait,
}
"""Internal actions by name and number of arguments, -1 for any."""
_WRITE: dict[type, Callable[[BodyWriter, int, Any, Scope], Scope]] = {
    AchievementGoal: _achieve,
    TestGoal: _test,
    BeliefUpdate: _believe,
    ExternalAction: _act,
    InternalActionCall: _internal,
    ConditionStatement: _check,
    If: _if,
    While: _while,
    For: _for,
}
