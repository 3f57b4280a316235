"""Mutation operators for robot code: messages, waits, times and speeds, states, resets, commands, decisions.

An operator is a function of a syntax node, its file and the names of the code; it yields pairs of a node and its
replacement. `mutants` applies all (`ROBOT`), besides operators of mutmut, which change single expressions; these change
whole statements of kinds that matter in robot code. None makes a bug that a type checker finds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import libcst as cst
from libcst import matchers

from pytest_hricdv.extra.mutation.source import (
    NOTES,
    OPPOSITES,
    Names,
    Source,
    is_time_or_speed,
    last_name,
    name_of_call,
    next_other,
    string_value,
)

Change = tuple[cst.CSTNode, cst.CSTNode]
"""A node of the syntax tree, and its replacement."""

Changes = Callable[[cst.CSTNode, Source, Names], Iterator[Change]]
"""The type of an operator; it yields all changes of a node that it makes."""

_MESSAGE = frozenset({"publish", "send", "emit", "broadcast", "notify", "say", "tell"})
_WAIT = frozenset({"sleep", "wait", "pause", "delay"})
_RESET = frozenset({"clear", "reset", "flush", "forget"})
_LOCKS = frozenset({"lock", "rlock", "mutex", "semaphore", "condition", "guard"})
_SCALES = ("0.1", "10")
_CONSTRUCTORS = frozenset({"__init__", "__post_init__", "__new__"})
_LEAVING = (cst.Return, cst.Raise, cst.Break, cst.Continue)


def message_dropped(node: cst.CSTNode, source: Source, names: Names) -> Iterator[Change]:
    """A message is not sent."""
    if _words(node) & _MESSAGE:
        yield node, cst.Pass()


def wait_skipped(node: cst.CSTNode, source: Source, names: Names) -> Iterator[Change]:
    """Drop a wait whose result is unused."""
    if _words(node) & _WAIT:
        yield node, cst.Pass()


def reset_forgotten(node: cst.CSTNode, source: Source, names: Names) -> Iterator[Change]:
    """Drop a reset, so that earlier state stays."""
    if _words(node) & _RESET:
        yield node, cst.Pass()


def call_dropped(node: cst.CSTNode, source: Source, names: Names) -> Iterator[Change]:
    """Drop any other call whose result is unused."""
    words = _words(node)
    if words and not words & (_MESSAGE | _WAIT | _RESET):
        yield node, cst.Pass()


def call_repeated(node: cst.CSTNode, source: Source, names: Names) -> Iterator[Change]:
    """Repeat an action or message; not a wait: another operator makes it longer."""
    line, words = source.parent(node), _words(node)
    if words and not words & (_WAIT | _RESET) and isinstance(line, cst.SimpleStatementLine) and len(line.body) == 1:
        (call,) = line.body
        yield line, line.with_changes(body=(call.with_changes(semicolon=_SEMICOLON), call))


def order_exchanged(node: cst.CSTNode, source: Source, names: Names) -> Iterator[Change]:
    """Swap a statement and the next one, unless that one needs what this one assigns."""
    block = source.parent(node)
    if not isinstance(block, cst.IndentedBlock) or not isinstance(node, cst.BaseStatement):
        return
    if isinstance(source.parent(block), cst.ClassDef):
        return
    body = list(block.body)
    here = body.index(node)
    pair = body[here : here + 2]
    if len(pair) == 2 and all(map(_acts, pair)) and not _target_names(pair[0]) & _names_in(pair[1]):
        body[here : here + 2] = reversed(pair)
        yield block, block.with_changes(body=body)


def time_or_speed_scaled(node: cst.CSTNode, source: Source, names: Names) -> Iterator[Change]:
    """A time or a speed, by its name or as what a wait is given, is a tenth or ten times of what it should be."""
    if isinstance(node, cst.BaseExpression) and is_time_or_speed(_purpose(node, source)):
        text = source.module.code_for_node(node)
        for factor in _SCALES:
            yield node, cst.parse_expression(f"{_in_brackets(node, text)} * {factor}")


def states_swapped(node: cst.CSTNode, source: Source, names: Names) -> Iterator[Change]:
    """A state or an outcome is another one of the same table, function, enumeration or group of constants."""
    if isinstance(node, cst.DictElement):
        yield from _other_value(node, source)
    elif isinstance(node, cst.Return):
        yield from _other_text(node, _return_texts(source.around(node, cst.FunctionDef)))
    elif isinstance(node, cst.Assign):
        yield from _other_text(node, names.assigned.get(last_name(node.targets[0].target), ()))
    elif isinstance(node, cst.Attribute):
        member = next_other(node.attr.value, names.members.get(last_name(node.value), ()))
        if member is not None:
            yield node.attr, cst.Name(member)
    elif isinstance(node, cst.Name) and _is_read(node, source):
        for text in names.constants.get(node.value, ())[:1]:
            yield node, cst.parse_expression(repr(text))


def assignment_forgotten(node: cst.CSTNode, source: Source, names: Names) -> Iterator[Change]:
    """Drop an assignment to state; outside of constructors, where the attribute would be missing."""
    function = source.around(node, cst.FunctionDef)
    if isinstance(function, cst.FunctionDef) and function.name.value not in _CONSTRUCTORS:
        kept = isinstance(node, cst.Assign) and isinstance(node.targets[0].target, cst.Attribute | cst.Subscript)
        if kept or isinstance(node, cst.AugAssign):
            yield node, cst.Pass()


def lock_removed(node: cst.CSTNode, source: Source, names: Names) -> Iterator[Change]:
    """Others may come in between: a block does not take its lock."""
    if isinstance(node, cst.WithItem) and not {*last_name(node.item).lower().split("_")}.isdisjoint(_LOCKS):
        yield node.item, cst.parse_expression('__import__("contextlib").nullcontext()')


def condition_negated(node: cst.CSTNode, source: Source, names: Names) -> Iterator[Change]:
    """A decision is taken the other way round; where one word of the condition says which, the library changes it."""
    if isinstance(node, cst.If | cst.While | cst.CompIf) and not matchers.matches(node.test, _REVERSIBLE):
        yield node.test, cst.parse_expression(f"not ({source.module.code_for_node(node.test)})")


def off_by_one(node: cst.CSTNode, source: Source, names: Names) -> Iterator[Change]:
    """A whole number is one less (one more is an operator of the library); a loop runs once less or more."""
    if isinstance(node, cst.Integer):
        yield node, cst.parse_expression(f"({node.evaluated_value - 1})")
    elif name_of_call(node) == "range" and isinstance(node, cst.Call):
        stop = node.args[:2][-1].value
        if not isinstance(stop, cst.BaseNumber):
            text = source.module.code_for_node(stop)
            yield from ((stop, cst.parse_expression(f"{_in_brackets(stop, text)} {sign} 1")) for sign in "-+")


def loop_left_early(node: cst.CSTNode, source: Source, names: Names) -> Iterator[Change]:
    """A loop ends after its first pass."""
    if isinstance(node, cst.For | cst.While) and isinstance(node.body, cst.IndentedBlock):
        body = node.body.body
        if not _leaves(body[-1]):
            yield node.body, node.body.with_changes(body=(*body, cst.SimpleStatementLine([cst.Break()])))


def return_early(node: cst.CSTNode, source: Source, names: Names) -> Iterator[Change]:
    """A function that returns no value returns after its first statement."""
    function = source.around(node, cst.FunctionDef)
    if not isinstance(node, cst.BaseStatement) or not isinstance(function, cst.FunctionDef):
        return
    if function.name.value in _CONSTRUCTORS or matchers.findall(function, _VALUE):
        return
    body = [statement for statement in function.body.body if not matchers.matches(statement, _DOCSTRING)]
    if node in body[1:2]:
        yield node, cst.SimpleStatementLine([cst.Return()])


def command_reversed(node: cst.CSTNode, source: Source, names: Names) -> Iterator[Change]:
    """The opposite command is given, of those that the code gives to the same thing elsewhere."""
    if isinstance(node, cst.Call) and isinstance(node.func, cst.Attribute):
        receiver, method = last_name(node.func.value), node.func.attr
        for opposite in OPPOSITES.get(method.value, ()):
            if (receiver, opposite) in names.commands:
                yield method, cst.Name(opposite)


_VALUE = matchers.Return(value=matchers.MatchIfTrue(lambda value: value is not None)) | matchers.Yield()
_REVERSIBLE = matchers.UnaryOperation(operator=matchers.Not()) | matchers.Comparison(
    comparisons=[
        matchers.ComparisonTarget(
            operator=matchers.Equal()
            | matchers.NotEqual()
            | matchers.Is()
            | matchers.IsNot()
            | matchers.In()
            | matchers.NotIn()
        )
    ]
)
_SEMICOLON = cst.Semicolon(whitespace_after=cst.SimpleWhitespace(" "))
_DOCSTRING = matchers.SimpleStatementLine([matchers.Expr(matchers.SimpleString())])


def _words(node: cst.CSTNode) -> set[str]:
    """The words of the name that a statement calls: `send` and `goal` of `arm.send_goal(...)`; else none."""
    if not isinstance(node, cst.Expr):
        return set()
    call = node.value.expression if isinstance(node.value, cst.Await) else node.value
    return {*name_of_call(call).split("_")} - {""}


def _acts(statement: cst.CSTNode) -> bool:
    """Whether a statement does something, and leaves the control flow to what follows it."""
    if isinstance(statement, cst.FunctionDef | cst.ClassDef) or _leaves(statement):
        return False
    return any(name_of_call(call) not in NOTES for call in matchers.findall(statement, matchers.Call()))


def _leaves(statement: cst.CSTNode) -> bool:
    return isinstance(statement, cst.SimpleStatementLine) and isinstance(statement.body[-1], _LEAVING)


def _target_names(node: cst.CSTNode) -> set[str]:
    targets = matchers.findall(node, matchers.AssignTarget() | matchers.NamedExpr())
    return {
        name
        for target in targets
        if isinstance(target, cst.AssignTarget | cst.NamedExpr)
        for name in _names_in(target.target)
    }


def _names_in(node: cst.CSTNode) -> set[str]:
    return {name.value for name in matchers.findall(node, matchers.Name()) if isinstance(name, cst.Name)}


def _purpose(node: cst.BaseExpression, source: Source) -> str:
    """The name that says what a value is for: of what is set to it or given it, else its own."""
    parent = source.parent(node)
    if isinstance(node, cst.BaseNumber):
        match parent:
            case cst.AnnAssign():
                return last_name(parent.target)
            case cst.Assign():
                return last_name(parent.targets[0].target)
            case cst.Param():
                return parent.name.value
            case cst.DictElement():
                return string_value(parent.key) or ""
    if isinstance(parent, cst.Arg):
        if parent.keyword is not None:
            return parent.keyword.value
        call = source.parent(parent)
        assert call is not None, "an argument is in a call"
        if not {*name_of_call(call).split("_")}.isdisjoint(_WAIT):
            return "duration"
        return last_name(node)
    return ""


def _in_brackets(node: cst.BaseExpression, text: str) -> str:
    simple = cst.BaseNumber | cst.Name | cst.Attribute | cst.Call | cst.Subscript
    return text if isinstance(node, simple) else f"({text})"


def _other_value(node: cst.DictElement, source: Source) -> Iterator[Change]:
    """The value of the next entry of its table that is another one of the same kind."""
    table = source.parent(node)
    assert isinstance(table, cst.Dict), "an entry is in a dictionary"
    texts = [
        source.module.code_for_node(entry.value)
        for entry in table.elements
        if isinstance(entry.value, type(node.value))
    ]
    other = next_other(source.module.code_for_node(node.value), texts)
    if other is not None:
        yield node.value, cst.parse_expression(other)


def _other_text(node: cst.Return | cst.Assign, texts: Sequence[str]) -> Iterator[Change]:
    text = string_value(node.value)
    other = None if text is None else next_other(text, texts)
    if node.value is not None and other is not None:
        yield node.value, cst.parse_expression(repr(other))


def _return_texts(function: cst.CSTNode | None) -> Sequence[str]:
    """The texts that a function returns."""
    if function is None:
        return ()
    returns = matchers.findall(function, matchers.Return())
    texts = (string_value(statement.value) for statement in returns if isinstance(statement, cst.Return))
    return [text for text in texts if text is not None]


def _is_read(node: cst.Name, source: Source) -> bool:
    """Whether a name stands for its value: it is neither assigned nor a part of another name."""
    parent = source.parent(node)
    if isinstance(parent, cst.Arg):
        return parent.keyword is not node
    if source.around(node, cst.FunctionDef) is None:  # a table of constants, which names them all
        return False
    return not isinstance(parent, cst.AssignTarget | cst.AnnAssign | cst.Attribute | cst.Param | cst.NamedExpr)


ROBOT: Mapping[str, Changes] = {
    "message dropped": message_dropped,
    "wait skipped": wait_skipped,
    "time or speed scaled": time_or_speed_scaled,
    "states swapped": states_swapped,
    "reset forgotten": reset_forgotten,
    "assignment forgotten": assignment_forgotten,
    "call dropped": call_dropped,
    "call repeated": call_repeated,
    "order exchanged": order_exchanged,
    "command reversed": command_reversed,
    "lock removed": lock_removed,
    "condition negated": condition_negated,
    "off by one": off_by_one,
    "loop left early": loop_left_early,
    "returned early": return_early,
}
"""Name of an operator in reports -> the operator."""
