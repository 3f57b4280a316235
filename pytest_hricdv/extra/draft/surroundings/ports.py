"""The ports of an entry: what a function or a class has to be handed."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import replace

from pytest_hricdv.extra.draft.found.findings import Operation, Part, Port
from pytest_hricdv.extra.draft.messages.fields import KINDS
from pytest_hricdv.extra.draft.messages.speech import SAYS, SUBSCRIBES
from pytest_hricdv.extra.draft.reading.classes import form_of
from pytest_hricdv.extra.draft.reading.constants import is_enum
from pytest_hricdv.extra.draft.reading.naming import unit_of
from pytest_hricdv.extra.draft.reading.neutral import neutral
from pytest_hricdv.extra.draft.reading.sources import Function, Module, Scope, Sources, dotted_name
from pytest_hricdv.extra.draft.reading.value_flow import ValueFlow, default_of, last_name, parameter_names
from pytest_hricdv.extra.draft.surroundings.operations import OperationFinder, merged
from pytest_hricdv.extra.draft.surroundings.parts import PartReader

QUEUE = {"get", "put", "get_nowait", "put_nowait", "empty", "qsize", "task_done", "join", "full"}
CLOCK = {"sleep", "now_s", "now", "time", "monotonic"}

_BUSES = re.compile(r"bus|broker|hub|events|messenger|mediator|mqtt")
"""In names of parameters that messages go by, whatever its methods are called."""


class PortReader:
    """Reads the ports of functions and classes."""

    def __init__(self, sources: Sources, flow: ValueFlow) -> None:
        self._sources = sources
        self._operations = OperationFinder(sources, flow)
        self._parts = PartReader(sources, flow)

    def ports(self, scope: Scope, skip: int = 0) -> Iterator[Port]:
        assert not isinstance(scope.node, ast.ClassDef)
        for name in parameter_names(scope.node)[skip:]:
            yield self.port(scope, name)

    def fields(self, scope: Scope) -> Iterator[Port]:
        """Of a dataclass, its fields are the parameters."""
        assert isinstance(scope.node, ast.ClassDef)
        if form_of(self._sources, scope) != "dataclass":
            return
        for statement in scope.node.body:
            if isinstance(statement, ast.AnnAssign) and isinstance(statement.target, ast.Name):
                name, default = statement.target.id, ast.unparse(statement.value) if statement.value else ""
                operations = tuple(self._operations.of_attribute(scope.node, name, 0))
                written = ast.unparse(statement.annotation)
                role = self._role(name, written, default, operations, scope.module)
                made = neutral(self._sources, scope.module, statement.annotation) or ("", ())
                place = scope.module.place(statement)
                yield Port(name, role, written, default, operations, place, _side(operations), False, *made)

    def port(self, scope: Scope, name: str) -> Port:
        function = scope.node
        assert not isinstance(function, ast.ClassDef)
        part = next(
            p for p in (*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs) if p.arg == name
        )
        written = ast.unparse(part.annotation).strip("'\"") if part.annotation is not None else ""
        default = default_of(function, name)
        text = ast.unparse(default) if default is not None else ""
        unique: dict[str, Operation] = {}
        for operation in self._operations.of_parameter(scope, name, 0):
            unique[operation.name] = merged(unique.get(operation.name), operation)
        operations = tuple(self._typed(operation, part.annotation, scope.module) for operation in unique.values())
        role = self._role(name, written, text, operations, scope.module)
        keyword = part in function.args.kwonlyargs
        made = neutral(self._sources, scope.module, part.annotation) or ("", ())
        return Port(name, role, written, text, operations, scope.module.place(part), _side(operations), keyword, *made)

    def _typed(self, operation: Operation, annotation: ast.expr | None, module: Module) -> Operation:
        """The same with what the class of the annotation says that it returns."""
        own = self._sources.class_of(module, annotation)
        if own is None or not isinstance(own.node, ast.ClassDef):
            return operation
        for statement in own.node.body:
            if isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef) and statement.name == operation.name:
                returns = ast.unparse(statement.returns) if statement.returns is not None else operation.returns
                is_async = isinstance(statement, ast.AsyncFunctionDef) or operation.is_async
                is_property = any(last_name(decorator) == "property" for decorator in statement.decorator_list)
                kind = "attribute" if is_property else operation.kind
                names = tuple(parameter_names(statement)[1:])
                told = tuple(_kind_of_argument(statement, name) for name in names)
                place = own.module.place(statement)
                is_read = kind == "attribute"
                made = neutral(self._sources, own.module, statement.returns)
                text, needs = made or ("", ())
                parts = _named(self._parts.parts(own.module, statement.returns), operation.parts)
                told_parts = tuple(self._parts.parts(own.module, _annotation(statement, name)) for name in names)
                return Operation(operation.name, "attribute" if is_read else "method", names, returns, place, is_async,
                                 compared=operation.compared, usual=operation.usual, made=text, needs=needs,
                                 told=told, parts=parts, told_parts=told_parts)  # fmt: skip
            if isinstance(statement, ast.AnnAssign) and dotted_name(statement.target) == operation.name:
                returns, place = ast.unparse(statement.annotation), own.module.place(statement)
                told = (KINDS.get(returns, ""),)
                return Operation(operation.name, "attribute", (), returns, place,
                                 is_set=operation.is_set, told=told)  # fmt: skip
        return operation

    def _role(self, name: str, written: str, default: str, operations: tuple[Operation, ...], module: Module) -> str:
        used = {operation.name for operation in operations}
        if "Queue" in written or (used and used <= QUEUE and used & {"get", "put", "get_nowait", "put_nowait"}):
            return "queue"
        if "StreamReader" in written or used & {"readline", "readexactly", "readuntil"}:
            return "reader"
        if "StreamWriter" in written or (used and used <= {"write", "drain", "close", "wait_closed", "is_closing"}):
            return "writer"
        verbs = {operation.strip("_") for operation in used}
        if used & {"publish", "subscribe", "emit"} or (_BUSES.search(name) and verbs & {*SAYS, *SUBSCRIBES}):
            return "bus"
        if used == {"__call__"} and any(
            word in name for word in ("publish", "send", "say", "emit", "on_", "notify", "report")
        ):
            return "publish"
        if (used and used <= CLOCK) or name == "clock":
            return "clock"
        if used & {"__call__"} and name in ("sleep", "now", "clock", "time"):
            return "clock"
        own = self._sources.class_of(module, _parsed(written))
        if own is not None and form_of(self._sources, own) in ("dataclass", "model", "namedtuple"):
            return "settings"
        if own is not None and is_enum(self._sources, own):
            return "parameter"
        if written in ("int", "float", "str", "bool") or unit_of(name) or (default and not used):
            return "parameter"
        return "device" if used or written or name in ("robot", "arm", "base", "gripper", "driver") else "parameter"


def _named(parts: tuple[Part, ...], unpacked: tuple[Part, ...]) -> tuple[Part, ...]:
    """Parts that an annotation says, by the names that the code gives them where it unpacks them."""
    if len(parts) != len(unpacked) or any(part.name for part in parts):
        return parts or unpacked
    return tuple(replace(part, name=other.name) for part, other in zip(parts, unpacked, strict=True))


def _parsed(text: str) -> ast.expr | None:
    try:
        return ast.parse(text, mode="eval").body if text else None
    except SyntaxError:
        return None


def _annotation(function: Function, name: str) -> ast.expr | None:
    """The annotation of an argument."""
    arguments = function.args
    parts = [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs]
    return next((part.annotation for part in parts if part.arg == name), None)


def _kind_of_argument(function: Function, name: str) -> str:
    """What an annotation says of the kind of an argument: "bool", "float", "str"; empty where it does not."""
    annotation = _annotation(function, name)
    return KINDS.get(ast.unparse(annotation), "") if annotation is not None else ""


def _side(operations: tuple[Operation, ...]) -> str:
    used = {operation.name for operation in operations}
    heard, said = bool(used & {"get", "get_nowait"}), bool(used & {"put", "put_nowait"})
    return "heard" if heard and not said else "said" if said and not heard else ""
