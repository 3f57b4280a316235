"""The nodes of ROS 2 in code that uses `rclpy`: their topics, services, actions, parameters and timers.

As `rclpy` has them: what `create_publisher` and the others are called with, and the names as ROS expands them.
Nothing is imported, neither the code nor `rclpy`.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace

from pytest_hricdv.extra.draft.code.flow import CallSite, Flow
from pytest_hricdv.extra.draft.code.sources import Module, Scope, Sources, name_with_dots, resolve_import
from pytest_hricdv.extra.draft.ros_model import CodeLine, Endpoint, EndpointKind, RosNodes, RosParameter

_PARAMETERS: dict[str, tuple[EndpointKind, int, tuple[str, ...], tuple[str, ...], tuple[str, ...]]] = {
    "create_publisher": ("publisher", 0, ("msg_type",), ("topic",), ()),
    "create_lifecycle_publisher": ("publisher", 0, ("msg_type",), ("topic",), ()),
    "create_subscription": ("subscription", 0, ("msg_type",), ("topic",), ("callback",)),
    "create_service": ("service", 0, ("srv_type",), ("srv_name",), ("callback",)),
    "create_client": ("client", 0, ("srv_type",), ("srv_name",), ()),
    "ActionServer": ("action server", 1, ("action_type",), ("action_name",), ("execute_callback",)),
    "ActionClient": ("action client", 1, ("action_type",), ("action_name",), ()),
}
"""Called -> its kind, the index of the type among the arguments, the names of type, name, callback (`rclpy` 9.1)."""

FOLDERS = ("msg", "srv", "action")
NODES = ("rclpy.node.Node", "rclpy.lifecycle.Node", "rclpy.lifecycle.LifecycleNode", "rclpy.create_node", "rclpy.Node")
"""The classes, and the function, that make a node."""


@dataclass(frozen=True)
class _NodeName:
    """The node that a call belongs to."""

    name: str = ""
    namespace: str = ""


def ros_nodes(sources: Sources, flow: Flow) -> RosNodes:
    """The endpoints and parameters of the code's nodes; none if it does not use `rclpy`."""
    if not any(name.partition(".")[0] == "rclpy" for module in sources.modules for name in module.imports.values()):
        return RosNodes()
    reader = _NodeReader(sources, flow)
    return RosNodes(tuple(reader.nodes()), tuple(reader.endpoints()), tuple(ros_parameters(flow)))


def ros_parameters(flow: Flow) -> Iterator[RosParameter]:
    """The parameters that nodes declare with `declare_parameter` and `declare_parameters`."""
    for call in flow.calls.get("declare_parameter", ()):
        yield from _parameter(flow, call, _argument(call.node, 0, "name"), _argument(call.node, 1, "value"), "")
    for call in flow.calls.get("declare_parameters", ()):
        space = next(iter(_texts(flow, call, _argument(call.node, 0, "namespace"))), "")
        for pairs, _, _ in flow.expressions(_argument(call.node, 1, "parameters"), call.module, call.scope):
            for pair in pairs.elts if isinstance(pairs, ast.List | ast.Tuple) else ():
                if isinstance(pair, ast.Tuple) and pair.elts:
                    default = pair.elts[1] if len(pair.elts) > 1 else None
                    yield from _parameter(flow, call, pair.elts[0], default, space)


def _parameter(
    flow: Flow, call: CallSite, name: ast.expr | None, default: ast.expr | None, space: str
) -> Iterator[RosParameter]:
    owner = call.scope.owner.name if call.scope is not None and call.scope.owner is not None else ""
    location = call.module.location(name or call.node)
    constants = flow.values(default, call.module, call.scope) if default is not None else []
    text = ast.unparse(default) if default is not None else ""
    if len(constants) == 1:
        text = repr(constants[0])
    for name_text in _texts(flow, call, name):
        full = f"{space}.{name_text}" if space else name_text
        yield RosParameter(full, text, owner, location)


def _texts(flow: Flow, call: CallSite, expression: ast.expr | None) -> list[str]:
    """The texts that an expression can be."""
    return [value for value in _values(flow, call, expression) if isinstance(value, str)]


def _values(flow: Flow, call: CallSite, expression: ast.expr | None) -> list[object]:
    """The constants that an expression can be; of a parameter that it declares or reads, its default."""
    values: list[object] = []
    for node, module, scope in flow.expressions(expression, call.module, call.scope):
        if isinstance(node, ast.expr):
            values += flow.values(node, module, scope)
        value = node.value if isinstance(node, ast.Attribute) and node.attr == "value" else node
        called = name_with_dots(value.func).rpartition(".")[2] if isinstance(value, ast.Call) else ""
        if isinstance(value, ast.Call) and called == "declare_parameter":
            values += flow.values(_argument(value, 1, "value"), module, scope)
        for inner in ast.walk(node) if not called or called == "get_parameter" else ():
            if isinstance(inner, ast.Call) and name_with_dots(inner.func).endswith(".get_parameter"):
                values += _default(flow, flow.values(_argument(inner, 0, "name"), module, scope))
    return [value for number, value in enumerate(values) if value not in values[:number]]


def _default(flow: Flow, names: list[object]) -> list[object]:
    """The default of a parameter that is a text or a number."""
    wanted = [name for name in names if isinstance(name, str)]
    defaults: list[object] = []
    for parameter in ros_parameters(flow) if wanted else ():
        if parameter.name in wanted:
            with suppress(ValueError, SyntaxError):
                defaults.append(ast.literal_eval(parameter.default))
    return [value for value in defaults if isinstance(value, str | int | float)]


def _argument(node: ast.Call, number: int, name: str) -> ast.expr | None:
    positional = [argument for argument in node.args if not isinstance(argument, ast.Starred)]
    by_name = next((keyword.value for keyword in node.keywords if keyword.arg == name), None)
    return by_name if by_name is not None or number >= len(positional) else positional[number]


class _NodeReader:
    """Reads calls of `rclpy` in all functions of the code."""

    def __init__(self, sources: Sources, flow: Flow) -> None:
        self._sources, self._flow = sources, flow

    def nodes(self) -> Iterator[tuple[str, CodeLine]]:
        """Classes of nodes, but those that only others are derived from, and nodes that functions make."""
        classes = [scope for scope in self._sources.classes if self._is_node(scope)]
        bases = {base.rpartition(".")[2] for scope in classes for base in self._sources.bases(scope)}
        for scope in classes:
            assert isinstance(scope.node, ast.ClassDef)
            if scope.node.name not in bases or scope.node.name in self._flow.calls:
                yield self._class_owner(scope.module, scope.node).name, scope.location
        for calls in self._flow.calls.values():
            for call in calls:
                if self._makes_node(call.module, call.node):
                    yield self._owner_of(call, call.node).name, call.module.location(call.node)

    def endpoints(self) -> Iterator[Endpoint]:
        """Topics, services and actions."""
        read = [endpoint for called in _PARAMETERS for call in self._flow.calls.get(called, ())
                for endpoint in self._call_endpoints(called, call)]  # fmt: skip
        yield from sorted(read, key=lambda endpoint: endpoint.location)

    def _call_endpoints(self, called: str, call: CallSite) -> Iterator[Endpoint]:
        kind, first, type_names, names, callbacks = _PARAMETERS[called]
        if first and not resolve_import(call.module, call.node.func).startswith("rclpy."):
            return
        types = self._types(call, _argument(call.node, first, type_names[0]))
        name = _argument(call.node, first + 1, names[0])
        callback = _argument(call.node, first + 2, callbacks[0]) if callbacks else None
        owner = self._owner(call, _argument(call.node, 0, "node") if first else None)
        endpoint = Endpoint(
            kind, "", types[0] if len(types) == 1 else "", owner.name,
            ast.unparse(callback) if callback is not None else "", call.module.location(call.node),
        )  # fmt: skip
        for text in _texts(self._flow, call, name) or [""]:
            yield replace(endpoint, name=_expand(text, owner))

    def _types(self, call: CallSite, expression: ast.expr | None) -> list[str]:
        types: dict[str, None] = {}
        for node, module, _ in self._flow.expressions(expression, call.module, call.scope):
            parts = resolve_import(module, node).split(".")
            if len(parts) == 3 and parts[1] in FOLDERS:
                types["/".join(parts)] = None
        return list(types)

    def _owner(self, call: CallSite, passed: ast.expr | None) -> _NodeName:
        """The node on which something is created: `self`, or a variable that holds one."""
        receiver = passed
        if receiver is None and isinstance(call.node.func, ast.Attribute):
            receiver = call.node.func.value
        own = call.scope.owner if call.scope is not None else None
        if isinstance(receiver, ast.Name) and receiver.id == "self" and own is not None:
            return self._class_owner(call.module, own)
        for node, module, scope in self._flow.expressions(receiver, call.module, call.scope):
            if isinstance(node, ast.Call):
                if self._makes_node(module, node):
                    return self._owner_of(CallSite(module, scope, node), node)
                made = self._sources.class_of(module, node.func)
                if made is not None and isinstance(made.node, ast.ClassDef) and self._is_node(made):
                    return self._class_owner(made.module, made.node)
        return _NodeName()

    def _class_owner(self, module: Module, node: ast.ClassDef) -> _NodeName:
        """The class that says it; else its base in the code, or the only derived class."""
        owner = self._name_in(node)
        if owner.name:
            return owner
        for base in node.bases:
            own = self._sources.class_of(module, base)
            if own is not None and isinstance(own.node, ast.ClassDef) and own.node is not node:
                owner = self._name_in(own.node)
                if owner.name:
                    return owner
        derived = {self._name_in(scope.node) for scope in self._sources.classes
                   if isinstance(scope.node, ast.ClassDef)
                   and any(base.rpartition(".")[2] == node.name for base in self._sources.bases(scope))}  # fmt: skip
        return derived.pop() if len(derived) == 1 else _NodeName()

    def _name_in(self, node: ast.ClassDef) -> _NodeName:
        """The name in `super().__init__(name)`."""
        for call in self._flow.calls.get("__init__", ()):
            if call.scope is not None and call.scope.owner is node and isinstance(call.node.func, ast.Attribute):
                is_super = isinstance(call.node.func.value, ast.Call)
                owner = self._owner_of(call, call.node, 0 if is_super else 1)
                if owner.name:
                    return owner
        return _NodeName()

    def _owner_of(self, call: CallSite, node: ast.Call, number: int = 0) -> _NodeName:
        names = _texts(self._flow, call, _argument(node, number, "node_name"))
        spaces = _texts(self._flow, call, _argument(node, 99, "namespace"))
        return _NodeName(names[0] if len(names) == 1 else "", spaces[0] if len(spaces) == 1 else "")

    def _makes_node(self, module: Module, node: ast.Call) -> bool:
        return resolve_import(module, node.func) in NODES

    def _is_node(self, scope: Scope) -> bool:
        return any(base in NODES for base in self._sources.bases(scope))


def _expand(name: str, owner: _NodeName) -> str:
    """A name as ROS expands it; empty if the name of the node is needed for it, and not known."""
    space = "/" + owner.namespace.strip("/") if owner.namespace.strip("/") else ""
    if name.startswith("/"):
        return name
    if name.startswith("~"):
        return f"{space}/{owner.name}/{name.lstrip('~/')}".rstrip("/") if owner.name else ""
    return f"{space}/{name}" if name else ""
