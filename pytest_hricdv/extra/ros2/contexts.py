"""Simulates the contexts (`Context`) and nodes (`GraphNode`) of `rclpy`.

`extension` gives `Context`, and a subclass of `GraphNode`, to `rclpy` in place of the classes of its C++ extension. A
`WorldNode` of the simulated world uses them, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partialmethod
from typing import Any

from pytest_hricdv.extra.ros2 import names
from pytest_hricdv.extra.ros2.arguments import Arguments, InvalidROSArgsError, matches_node, parse
from pytest_hricdv.extra.ros2.graph import Graph, graph_of
from pytest_hricdv.extra.ros2.handles import Destroyable, RCLError, current_kernel
from pytest_hricdv.extra.ros2.messages import type_name
from pytest_hricdv.extra.ros2.processes import process_of
from pytest_hricdv.runtime.kernel import Kernel, current_node

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

DEFAULT_DOMAIN = 2**64 - 1
"""Like `RCL_DEFAULT_DOMAIN_ID`: no domain is given, which means 0 here; ROS_DOMAIN_ID is ignored."""


class Context(Destroyable):
    """Like `rcl_context_t`: what one process of a ROS 2 system shares.

    Raises:
        KernelError: made outside of a node of a simulated run.
        RCLError: wrong ROS arguments.
        UnknownROSArgsError: unknown ROS arguments.
    """

    def __init__(self, arguments: Sequence[str], domain_id: int, kernel: Kernel | None = None) -> None:
        super().__init__(kernel or current_kernel("rclpy.init"))
        try:
            self.arguments = parse(arguments)
        except InvalidROSArgsError as error:
            raise RCLError(str(error)) from None  # as rcl: the class of its own is for arguments of nodes
        self._domain = 0 if domain_id == DEFAULT_DOMAIN else domain_id
        self.is_valid = True
        """Whether it is not shut down."""
        process = process_of(current_node())
        if process is not None:
            process.at_end.append(self._end)

    @property
    def graph(self) -> Graph:
        """The graph of its domain."""
        return graph_of(self.kernel, self._domain)

    def get_domain_id(self) -> int:
        return self._domain

    def ok(self) -> bool:
        """Whether it is not shut down; counts as a poll, so that a loop that never sleeps is found."""
        self.kernel.count_poll()
        return self.is_valid

    def shutdown(self) -> None:
        """Shut it down, once. Raises RCLError the second time."""
        if not self.is_valid:
            raise RCLError("Context already shutdown.")
        self._end()

    def _end(self) -> None:
        """Let all that it has leave the graph."""
        if not self.is_valid:
            return
        self.is_valid = False
        for entity in self.graph.entities():
            if entity.node.context is self:
                entity.leave()
        for node in [*self.graph.nodes]:
            if node.context is self:
                node.leave()

    def require_valid(self, action: str) -> None:
        """Raise RCLError if the context is shut down; `action`, such as "create timer", is what needs it."""
        if not self.is_valid:
            problem = "the given context is not valid, either rcl_init() was not called or rcl_shutdown() was called."
            raise RCLError(f"failed to {action}: {problem}")


class GraphNode(Destroyable):
    """Like `rcl_node_t`. Its own arguments come before those of its context.

    Raises:
        ValueError: a wrong name or namespace.
    """

    def __init__(
        self,
        node_name: str,
        namespace_: str,
        context: Context,
        pycli_args: Sequence[str] | None,
        use_global_arguments: bool,
        enable_rosout: bool,
    ) -> None:
        super().__init__(context.kernel)
        self.context = context
        self.enable_rosout = enable_rosout
        own = parse(pycli_args or ())
        self._arguments: list[Arguments] = [own, context.arguments] if use_global_arguments else [own]
        self._name = self._new_name("__node", node_name) or self._new_name("__name", node_name) or node_name
        self._namespace = self._absolute(self._new_name("__ns", node_name) or namespace_)
        for kind, fault in (
            ("invalid node name", names.node_name_fault(self._name)),
            ("invalid node namespace", names.namespace_fault(self._namespace)),
        ):
            if fault:
                raise ValueError(f"{kind}: {fault[0]}, at index {fault[1]}")
        context.graph.nodes.append(self)

    def _new_name(self, source: str, node_name: str) -> str | None:
        return next((new for arguments in self._arguments if (new := arguments.new_name(source, node_name))), None)

    @staticmethod
    def _absolute(namespace: str) -> str:
        return namespace if namespace.startswith("/") else f"/{namespace}"

    def destroy(self) -> None:
        self.leave()

    def leave(self) -> None:
        """Be found in the graph no more; a second time has no effect."""
        if self in self.graph.nodes:
            self.graph.nodes.remove(self)

    @property
    def graph(self) -> Graph:
        """The graph that it is in."""
        return self.context.graph

    def admit(self, full_name: str, kind: type[Any]) -> None:
        """Use a topic or service.

        Raises:
            InputError: the testbench or another node has another type for it.
            RCLError: the context is shut down.
        """
        self.context.require_valid(f"use {full_name}")
        if self.graph.carrier is not None:
            domain, name = self.context.get_domain_id(), self.get_fully_qualified_name()
            self.graph.carrier.admit(domain, name, full_name, type_name(kind))

    def get_node_name(self) -> str:
        return self._name

    def get_namespace(self) -> str:
        return self._namespace

    def get_fully_qualified_name(self) -> str:
        """Namespace and name."""
        return f"{self._namespace.rstrip('/')}/{self._name}"

    def logger_name(self) -> str:
        """The name of its logger."""
        return self.get_fully_qualified_name()[1:].replace("/", ".")

    def remap(self, full_name: str) -> str:
        """The name that a topic or service has after the remappings; the first that fits counts."""
        for arguments in self._arguments:
            for rule in arguments.remappings:
                if rule.source.startswith("__") or rule.node not in ("", self._name):
                    continue
                if names.expand(rule.source, self._name, self._namespace) == full_name:
                    return names.expand(rule.target, self._name, self._namespace)
        return full_name

    def resolve(self, name: str) -> str:
        """The full name, remapped, of what code calls `name`. Raises ValueError for a wrong name."""
        full_name = self.remap(names.expand(name, self._name, self._namespace))
        fault = names.full_topic_name_fault(full_name)
        if fault:
            raise ValueError(f"topic name is invalid: {fault[0]}, at index {fault[1]}: '{full_name}'")
        return full_name

    def get_parameters(self, parameter_class: Any) -> dict[str, Any]:
        """The parameters that the arguments give it, as objects of `rclpy`'s class."""
        parameters = {}
        for arguments in reversed(self._arguments):  # its own last: later ones win
            for pattern, name, value in arguments.parameters:
                if matches_node(pattern, self.get_fully_qualified_name()):
                    kind = parameter_class.Type.from_parameter_value(value)
                    parameters[name] = parameter_class(name, kind, value)
        return parameters

    def _count(self, part: str, name: str) -> int:
        """The number of entities of a topic or service in a part of the graph."""
        fault = names.full_topic_name_fault(name)
        if fault:
            raise RCLError(f"'{name}': {fault[0]}")
        return len(getattr(self.graph, part).get(name, ()))

    get_count_publishers = partialmethod(_count, "publishers")
    get_count_subscribers = partialmethod(_count, "subscriptions")
    get_count_clients = partialmethod(_count, "clients")
    get_count_services = partialmethod(_count, "services")

    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]:
        return [(node.get_node_name(), node.get_namespace()) for node in self.graph.nodes]

    def get_node_names_and_namespaces_with_enclaves(self) -> list[tuple[str, str, str]]:
        """All nodes of the graph, each in the enclave "/"."""
        return [(*node, "/") for node in self.get_node_names_and_namespaces()]
