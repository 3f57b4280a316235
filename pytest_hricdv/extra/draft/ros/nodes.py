"""Finds the ROS 2 nodes in code that uses `rclpy`, with their topics, services, actions and parameters (`ros_nodes`).

It reads the arguments of `create_publisher` and the like, expands names as ROS does, and imports neither the code nor
`rclpy`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property

from pytest_hricdv.extra.draft.code.flow import CallSite, Flow, last_name
from pytest_hricdv.extra.draft.code.sources import Scope, Sources, name_with_dots, resolve_import
from pytest_hricdv.extra.draft.ros_model import CodeLine, Endpoint, EndpointKind, RosNodes, RosParameter

_PARAMETERS: dict[str, tuple[EndpointKind, int, str, str]] = {
    "create_publisher": ("publisher", 0, "msg_type", "topic"),
    "create_lifecycle_publisher": ("publisher", 0, "msg_type", "topic"),
    "create_subscription": ("subscription", 0, "msg_type", "topic"),
    "create_service": ("service", 0, "srv_type", "srv_name"),
    "create_client": ("client", 0, "srv_type", "srv_name"),
    "ActionServer": ("action server", 1, "action_type", "action_name"),
    "ActionClient": ("action client", 1, "action_type", "action_name"),
}
"""Function -> kind of endpoint, index of the type, parameter names of type and name (as of `rclpy` 9.1)."""

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
    """The default of a parameter that is a string or a number."""
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
        """The nodes that functions make, or whose classes begin them."""
        yield from {owner.name: (owner.name, call.module.location(call.node)) for call, owner in self._begins}.values()

    @cached_property
    def _begins(self) -> list[tuple[CallSite, _NodeName]]:
        """The calls that make a node, or are of the constructor of its class; each with its name."""
        found = []
        for call in [call for calls in self._flow.calls.values() for call in calls]:
            function, owner = call.node.func, call.scope.owner if call.scope is not None else None
            is_begin = isinstance(function, ast.Attribute) and function.attr == "__init__" and owner is not None
            if is_begin and owner is not None and self._is_node(Scope(call.module, owner)):
                is_super = isinstance(getattr(function, "value", None), ast.Call)
                found.append((call, self._name_of(call, 0 if is_super else 1)))
            elif resolve_import(call.module, function) in NODES:
                found.append((call, self._name_of(call, 0)))
        return found

    def endpoints(self) -> Iterator[Endpoint]:
        """Topics, services and actions."""
        read = [endpoint for called in _PARAMETERS for call in self._flow.calls.get(called, ())
                for endpoint in self._call_endpoints(called, call)]  # fmt: skip
        yield from sorted(read, key=lambda endpoint: endpoint.location)

    def _call_endpoints(self, called: str, call: CallSite) -> Iterator[Endpoint]:
        kind, first, type_name, topic_name = _PARAMETERS[called]
        if first and not resolve_import(call.module, call.node.func).startswith("rclpy."):
            return
        types = self._types(call, _argument(call.node, first, type_name))
        name = _argument(call.node, first + 1, topic_name)
        others = [*call.node.args[first + 2 :], *(keyword.value for keyword in call.node.keywords)]
        named = (last_name(node) for other in others for node in ast.walk(other))
        callbacks = tuple(dict.fromkeys(name for name in named if name in self._flow.methods))
        owner = self._owner(call)
        endpoint = Endpoint(kind, "", types[0] if len(types) == 1 else "", owner.name, callbacks,
                            call.module.location(call.node))  # fmt: skip
        for text in _texts(self._flow, call, name) or [""]:
            yield replace(endpoint, name=_expand(text, owner))

    def _types(self, call: CallSite, expression: ast.expr | None) -> list[str]:
        types: dict[str, None] = {}
        for node, module, _ in self._flow.expressions(expression, call.module, call.scope):
            parts = resolve_import(module, node).split(".")
            if len(parts) == 3 and parts[1] in FOLDERS:
                types["/".join(parts)] = None
        return list(types)

    def _owner(self, call: CallSite) -> _NodeName:
        """The only node of the function, else of the class or those that it is derived from, of the module, of all."""
        owner = call.scope.owner if call.scope is not None else None
        bases = self._sources.base_classes(Scope(call.module, owner)) if owner is not None else ()
        classes = {id(owner)} | {id(base.node) for base in bases} if owner is not None else set()
        nearest: tuple[Callable[[CallSite], bool], ...] = (
            lambda other: other.scope is not None and other.scope == call.scope,
            lambda other: other.scope is not None and id(other.scope.owner) in classes,
            lambda other: other.module is call.module,
            lambda other: True,
        )
        for is_near in nearest:
            names = {name for other, name in self._begins if is_near(other)}
            if names:
                return names.pop() if len(names) == 1 else _NodeName()
        return _NodeName()

    def _name_of(self, call: CallSite, number: int) -> _NodeName:
        names = _texts(self._flow, call, _argument(call.node, number, "node_name"))
        spaces = _texts(self._flow, call, _argument(call.node, 99, "namespace"))
        return _NodeName(names[0] if len(names) == 1 else "", spaces[0] if len(spaces) == 1 else "")

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
