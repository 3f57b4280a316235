"""Reads the ports of an entry: the parameters of a function or class, and what the code does with each."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import replace

from pytest_hricdv.extra.draft.code.classes import form_of, methods_of, neutral_value, parse_annotation
from pytest_hricdv.extra.draft.code.constants import assignments, is_enum
from pytest_hricdv.extra.draft.code.fields import FieldReader, merge_fields
from pytest_hricdv.extra.draft.code.flow import (
    Flow,
    argument_of,
    default_of,
    last_name,
    parameter_names,
    parameters_of,
)
from pytest_hricdv.extra.draft.code.naming import unit_of
from pytest_hricdv.extra.draft.code.sources import Module, Scope, Sources, name_with_dots
from pytest_hricdv.extra.draft.code_model import MessageField, Operation, Port

_QUEUE = {"get", "put", "get_nowait", "put_nowait", "empty", "qsize", "task_done", "join", "full"}
_CLOCK = {"sleep", "now_s", "now", "time", "monotonic"}
"""Methods that make a port a queue, or a clock."""

_PLAIN = ("int", "float", "str", "bool", "dict", "list", "tuple", "set", "frozenset", "Mapping", "Sequence")
"""Annotations of values that are not objects."""

MAX_HANDOVERS = 3
"""Most calls and attributes through which a port is followed."""


class PortReader:
    """Reads ports for `EntryFinder`, and those of objects that the code creates."""

    def __init__(self, sources: Sources, flow: Flow) -> None:
        self._sources, self._flow = sources, flow
        self._fields = FieldReader(sources, flow)

    def ports(self, scope: Scope, skip: int = 0) -> Iterator[Port]:
        """The parameters of a function, without the first ones."""
        assert not isinstance(scope.node, ast.ClassDef)
        for name in parameter_names(scope.node)[skip:]:
            yield self.port(scope, name)

    def fields(self, scope: Scope) -> Iterator[Port]:
        """The fields of a dataclass, which are its parameters."""
        assert isinstance(scope.node, ast.ClassDef)
        for statement in scope.node.body if form_of(self._sources, scope) == "dataclass" else ():
            if isinstance(statement, ast.AnnAssign) and isinstance(statement.target, ast.Name):
                name, default = statement.target.id, ast.unparse(statement.value) if statement.value else ""
                operations = list(self._attribute_operations(scope.node, name, 0))
                yield self._port(scope.module, name, statement.annotation, default, operations, statement)

    def attribute(self, owner: Scope, name: str, made_from: str, node: ast.AST) -> Port:
        """An attribute of a class that the code makes itself."""
        assert isinstance(owner.node, ast.ClassDef)
        operations = list(self._attribute_operations(owner.node, name, 0))
        return replace(self._port(owner.module, name, None, "", operations, node), made_from=made_from)

    def variable(self, module: Module, name: str, node: ast.AST) -> Port:
        """A variable of a module or of its functions, or an attribute, that the code makes itself."""
        operations = [operation for at, scope, use in self._flow.nodes
                      if isinstance(use, ast.Attribute) and scope is not None and at is module
                      and name_with_dots(use.value) == name
                      for operation in self._operations(use, at, scope)]  # fmt: skip
        return self._port(module, name.rpartition(".")[2], None, "", operations, node)

    def port(self, scope: Scope, name: str) -> Port:
        """A parameter of a function."""
        function = scope.node
        assert not isinstance(function, ast.ClassDef)
        part = next(parameter for parameter in parameters_of(function) if parameter.arg == name)
        default = default_of(function, name)
        operations = list(self._parameter_operations(scope, name, 0))
        written = ast.unparse(default) if default is not None else ""
        return self._port(scope.module, name, part.annotation, written, operations, part)

    def _port(
        self,
        module: Module,
        name: str,
        annotation: ast.expr | None,
        default: str,
        operations: list[Operation],
        node: ast.AST,
    ) -> Port:
        written = ast.unparse(annotation).strip("'\"") if annotation is not None else ""
        own = self._sources.class_of(module, parse_annotation(annotation))
        by_name: dict[str, Operation] = {}
        for operation in operations:
            by_name[operation.name] = _merge(by_name.get(operation.name), operation)
        declarations = {name: self._declaration(operation, own) for name, operation in by_name.items()}
        # Parts of a result are declared with its type.
        typed = {name for name, operation in declarations.items() if operation.returns}
        declared = tuple(
            operation
            for name, operation in declarations.items()
            if "." not in name or name.partition(".")[0].removesuffix("()") not in typed
        )
        used = set(by_name)
        role = self._role(name, written, default, {name for name in used if "." not in name}, own)
        received, published = used & {"get", "get_nowait"}, used & {"put", "put_nowait"}
        side = "received" if received and not published else "published" if published and not received else ""
        neutral, imports = neutral_value(self._sources, module, annotation) or ("", ())
        if default == "None" and role in ("device", "bus", "queue", "publish", "clock"):
            default = ""  # what the code makes itself where it gets nothing is its hardware
        return Port(name, role, written, default, declared, module.location(node), side, neutral, imports)

    def _role(self, name: str, written: str, default: str, used: set[str], own: Scope | None) -> str:
        if "Queue" in written or (used and used <= _QUEUE and used & {"get", "put", "get_nowait", "put_nowait"}):
            return "queue"
        if used & {"publish", "subscribe"}:
            return "bus"
        if (used and used <= _CLOCK) or name == "clock" or (used == {"__call__"} and name in _CLOCK):
            return "clock"
        if used == {"__call__"}:
            return "publish"
        if own is not None and form_of(self._sources, own) in ("dataclass", "model", "namedtuple"):
            return "settings"
        is_plain = (
            written.partition("[")[0].partition(" ")[0] in _PLAIN
            or unit_of(name)
            or (default and used <= {"__getitem__"})
        )
        if is_plain or (own is not None and is_enum(self._sources, own)):
            return "parameter"
        return "device" if used or written else "parameter"

    def _declaration(self, operation: Operation, own: Scope | None) -> Operation:
        """The operation with the declarations of the annotation's class."""
        for statement in own.node.body if own is not None else ():
            assert own is not None
            if isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef) and statement.name == operation.name:
                is_property = any(last_name(decorator) == "property" for decorator in statement.decorator_list)
                made = replace(operation, is_method=not is_property,
                               is_async=operation.is_async or isinstance(statement, ast.AsyncFunctionDef))  # fmt: skip
                return self._with_return(made, own, statement.returns, statement)
            if isinstance(statement, ast.AnnAssign) and name_with_dots(statement.target) == operation.name:
                return self._with_return(replace(operation, is_method=False), own, statement.annotation, statement)
        return operation

    def _with_return(self, operation: Operation, own: Scope, annotation: ast.expr | None, at: ast.AST) -> Operation:
        neutral, imports = neutral_value(self._sources, own.module, annotation) or ("", ())
        returns = ast.unparse(annotation).strip("'\"") if annotation is not None else ""
        location = own.module.location(at)
        result = operation.result
        if annotation is not None:
            declared = self._fields.field_of_type(own, "value", annotation)
            compared = result.compared if result is not None and declared.kind == "float" else ()
            values = declared.values or (result.values if result is not None and declared.kind == "str" else ())
            result = replace(declared, compared=compared, values=values)
            result = result if result.kind in ("bool", "float") or result.values else None
        return replace(operation, returns=returns, neutral=neutral, imports=imports, location=location, result=result)

    # --- what the code does with it

    def _parameter_operations(self, scope: Scope, name: str, handovers: int) -> Iterator[Operation]:
        """The operations of a function on a parameter, and those of functions to which it is passed on."""
        for node in ast.walk(scope.node) if handovers <= MAX_HANDOVERS else ():
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == name:
                yield from self._operations(node, scope.module, scope)
            elif isinstance(node, ast.Call):
                if isinstance(node.func, ast.Name) and node.func.id == name:
                    yield Operation("__call__", True, scope.module.location(node))
                yield from self._handovers(node, scope, name, handovers)
            for target, value in assignments(node) if scope.owner is not None else ():
                parts = value.values if isinstance(value, ast.BoolOp) else [value]
                parts = [value.body, value.orelse] if isinstance(value, ast.IfExp) else parts
                is_kept = any(isinstance(part, ast.Name) and part.id == name for part in parts)
                if is_kept and name_with_dots(target).startswith("self.") and scope.owner is not None:
                    yield from self._attribute_operations(scope.owner, name_with_dots(target)[5:], handovers + 1)

    def _attribute_operations(self, owner: ast.ClassDef, attribute: str, handovers: int) -> Iterator[Operation]:
        """The operations on an attribute of a class."""
        for module, scope, node in self._flow.nodes if handovers <= MAX_HANDOVERS else ():
            if scope is None:
                continue
            if isinstance(node, ast.Attribute) and self._is_attribute(node.value, owner, attribute, scope):
                yield from self._operations(node, module, scope)
            elif isinstance(node, ast.Call):
                if self._is_attribute(node.func, owner, attribute, scope):
                    yield Operation("__call__", True, module.location(node))
                for argument in (*node.args, *(keyword.value for keyword in node.keywords)):
                    if self._is_attribute(argument, owner, attribute, scope):
                        yield from self._operations_after(node, argument, scope, handovers)

    def _handovers(self, node: ast.Call, scope: Scope, name: str, handovers: int) -> Iterator[Operation]:
        for argument in (*node.args, *(keyword.value for keyword in node.keywords)):
            if isinstance(argument, ast.Name) and argument.id == name:
                yield from self._operations_after(node, argument, scope, handovers)

    def _operations_after(
        self, node: ast.Call, argument: ast.expr, scope: Scope, handovers: int
    ) -> Iterator[Operation]:
        for callee in self._callees(node, scope):
            assert not isinstance(callee.node, ast.ClassDef)
            for parameter in parameter_names(callee.node):
                if argument_of(node, callee.node, parameter, is_method=callee.owner is not None) is argument:
                    yield from self._parameter_operations(callee, parameter, handovers + 1)

    def _callees(self, node: ast.Call, scope: Scope) -> list[Scope]:
        own = self._sources.class_of(scope.module, node.func)
        if own is not None:
            begin = methods_of(self._sources, own).get("__init__")
            return [begin] if begin is not None else []
        methods = self._flow.methods.get(last_name(node.func), [])
        same = [method for method in methods if method.owner is scope.owner]
        kinds = {tuple(parameter_names(method.node)) for method in methods}  # type: ignore[arg-type]
        return same or (methods if len(kinds) == 1 else [])  # several classes have it, as states do

    def _is_attribute(self, node: ast.expr, owner: ast.ClassDef, attribute: str, scope: Scope) -> bool:
        if not isinstance(node, ast.Attribute) or node.attr != attribute:
            return False
        return self._flow.owner_of(node.value, scope.module, scope) is owner

    def _operations(self, node: ast.Attribute, module: Module, scope: Scope) -> Iterator[Operation]:
        """The operations on a method or attribute, and on the parts of its result: `nearest().distance`."""
        whole = self._operation(node, module, scope)
        parent = self._flow.parents.get(id(node))
        value = parent if isinstance(parent, ast.Call) and parent.func is node else node
        yield whole
        for part in self._parts(value, scope):
            result = self._used_as(part, scope)
            if result is not None:
                yield Operation(f"{whole.key}.{part.attr}", False, module.location(part), result=result)

    def _parts(self, value: ast.expr, scope: Scope) -> Iterator[ast.Attribute]:
        above = self._flow.parents.get(id(value))
        if isinstance(above, ast.Attribute):
            yield above
        for target, _ in assignments(above or value):
            for name in self._flow.names_in(scope).get(getattr(target, "id", ""), ()):
                part = self._flow.parents.get(id(name))
                if isinstance(part, ast.Attribute):
                    yield part

    def _operation(self, node: ast.Attribute, module: Module, scope: Scope) -> Operation:
        parent = self._flow.parents.get(id(node))
        location = module.location(node)
        if isinstance(parent, ast.Call) and parent.func is node:
            is_async = isinstance(self._flow.parents.get(id(parent)), ast.Await)
            every = (*parent.args, *(keyword.value for keyword in parent.keywords))
            takes = any(self._is_function(argument) for argument in every)
            takes |= isinstance(self._flow.parents.get(id(parent)), ast.FunctionDef | ast.AsyncFunctionDef)  # decorates
            name = node.attr if not _is_lookup(parent, node.attr) else "__getitem__"
            return Operation(name, True, location, is_async=is_async,
                             is_registration=takes, result=self._used_as(parent, scope))  # fmt: skip
        value = parent.value if isinstance(parent, ast.Assign) and node in parent.targets else None
        return Operation(node.attr, False, location, is_set=isinstance(node.ctx, ast.Store),
                         is_registration=self._is_function(value), result=self._used_as(node, scope))  # fmt: skip

    def _used_as(self, node: ast.expr, scope: Scope, returns: int = 0) -> MessageField | None:
        """The use of a value: a truth that is tested, or the value it is compared with; None if neither."""
        part = self._fields.read_value(node, scope, "value")
        if part.kind:
            return part
        above = self._flow.parents.get(id(node))
        if isinstance(above, ast.Return) and returns < MAX_HANDOVERS:
            calls = [call for call in self._flow.calls.get(scope.node.name, ()) if call.scope is not None]
            uses = (self._used_as(call.node, call.scope, returns + 1) for call in calls if call.scope is not None)
            return next((use for use in uses if use is not None), None)
        is_not = isinstance(above, ast.UnaryOp) and isinstance(above.op, ast.Not)
        is_test = isinstance(above, ast.If | ast.While | ast.IfExp) and above.test is node
        return replace(part, kind="bool") if is_test or is_not or isinstance(above, ast.BoolOp) else None

    def _is_function(self, value: ast.expr | None) -> bool:
        """Whether a value is a method of `self`, or a function, of the code."""
        name = name_with_dots(value) if not isinstance(value, ast.Constant) else "."
        is_own = name.startswith("self.") and name.count(".") == 1
        return (is_own or "." not in name) and name.rpartition(".")[2] in self._flow.methods


def _is_lookup(call: ast.Call, name: str) -> bool:
    """Whether `get` is called as a dict is: with a key, and not with whether to wait."""
    key = call.args[0] if name == "get" and call.args else None
    return key is not None and not isinstance(getattr(key, "value", None), bool)


def _merge(before: Operation | None, operation: Operation) -> Operation:
    """Two uses of the same operation as one."""
    if before is None:
        return operation
    return replace(
        before,
        is_method=before.is_method or operation.is_method,
        is_async=before.is_async or operation.is_async,
        is_set=before.is_set or operation.is_set,
        result=merge_fields(before.result, operation.result) if operation.result is not None else before.result,
        is_registration=before.is_registration or operation.is_registration,
    )
