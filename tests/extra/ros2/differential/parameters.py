"""Parameters: callbacks, descriptors, events, services, values from arguments."""

from __future__ import annotations

import rclpy
from rcl_interfaces.msg import (
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient

from tests.extra.ros2.differential.common import (
    PATIENCE_S,
    Log,
    System,
    alone,
    answered,
    raised,
    serving,
)


def configurable(log: Log) -> Node:
    node = Node("configurable")
    node.declare_parameter("speed", 0.5)

    def check(parameters: list[Parameter]) -> SetParametersResult:
        log("set", [[each.name, each.value] for each in parameters])
        return SetParametersResult(successful=all(each.value <= 1.0 for each in parameters), reason="too fast")

    node.add_on_set_parameters_callback(check)
    return node


def configuring(log: Log) -> None:
    rclpy.init()
    node = Node("configuring")
    client = AsyncParameterClient(node, "configurable")
    client.wait_for_services(PATIENCE_S)
    log("before", answered(node, client.get_parameters(["speed"])).values[0].double_value)
    for speed in (0.75, 2.0):
        answer = answered(node, client.set_parameters([Parameter("speed", value=speed)])).results[0]
        log("set", [answer.successful, answer.reason])
    log("after", answered(node, client.get_parameters(["speed"])).values[0].double_value)


def many(log: Log) -> Node:
    node = Node("many", namespace="/cell")
    node.declare_parameter("arm.speed", 0.5, ParameterDescriptor(description="of the arm"))
    node.declare_parameter("arm.joint.names", ["a", "b"])
    node.declare_parameter("count", 3)
    node.declare_parameter("fixed", "value", ParameterDescriptor(read_only=True))
    node.declare_parameter("bytes", [b"\x01", b"\x02"])
    return node


def asking(log: Log) -> None:
    """All services of parameters, from another process."""
    rclpy.init()
    node = Node("asking")
    client = AsyncParameterClient(node, "/cell/many")
    log("services", client.wait_for_services(PATIENCE_S))
    for prefixes, depth in (([], 0), (["arm"], 0), ([], 1), (["arm"], 1), (["nothing"], 0)):
        listed = answered(node, client.list_parameters(prefixes, depth)).result
        names = [name for name in listed.names if name != "use_sim_time" and "type_description" not in name]
        log("list", [prefixes, depth, sorted(names), sorted(listed.prefixes)])
    names = ["arm.speed", "arm.joint.names", "count", "fixed", "bytes", "missing"]
    log("types", list(answered(node, client.get_parameter_types(names)).types))
    described = answered(node, client.describe_parameters(names[:4])).descriptors
    log("descriptors", [[each.name, each.type, each.description, each.read_only] for each in described])
    values = answered(node, client.get_parameters(names)).values
    log("values", [str(value) for value in values])
    changes = [Parameter("count", value=4), Parameter("fixed", value="other"), Parameter("missing", value=1)]
    for result in answered(node, client.set_parameters(changes)).results:
        log("set", [result.successful, bool(result.reason)])
    result = answered(node, client.set_parameters_atomically(changes[:2])).result
    log("atomically", [result.successful, bool(result.reason)])
    wrong = answered(node, client.set_parameters([Parameter("count", value="four")])).results[0]
    log("wrong type", [wrong.successful, bool(wrong.reason)])
    deleted = answered(node, client.delete_parameters(["count"])).results[0]
    log("deleted", [deleted.successful, bool(deleted.reason)])
    log("count", answered(node, client.get_parameters(["count"])).values[0].integer_value)


def called_back(log: Log) -> None:
    """Callbacks before, during and after a change, and which of them are called when one refuses."""
    rclpy.init()
    node = Node("node")
    node.declare_parameters("", [("speed", 0.5), ("limit", 1.0), ("echo", 0.0)])

    def before(parameters: list[Parameter]) -> list[Parameter]:
        log("called", ["before", [[each.name, each.value] for each in parameters]])
        return [*parameters, Parameter("echo", value=parameters[0].value)]

    def check(parameters: list[Parameter]) -> SetParametersResult:
        log("called", ["check", [[each.name, each.value] for each in parameters]])
        limit = node.get_parameter("limit").value
        return SetParametersResult(successful=all(each.value <= limit for each in parameters), reason="limit")

    def check_first(parameters: list[Parameter]) -> SetParametersResult:
        log("called", ["check first", len(parameters)])
        return SetParametersResult(successful=parameters[0].value >= 0.0, reason="negative")

    def after(parameters: list[Parameter]) -> None:
        log("called", ["after", [[each.name, each.value] for each in parameters]])

    node.add_pre_set_parameters_callback(before)
    node.add_on_set_parameters_callback(check)
    node.add_on_set_parameters_callback(check_first)
    node.add_post_set_parameters_callback(after)
    for value in (0.75, 2.0, -1.0):
        result = node.set_parameters([Parameter("speed", value=value)])[0]
        log("results", [value, result.successful, result.reason])
    result = node.set_parameters_atomically([Parameter("speed", value=0.25), Parameter("limit", value=0.5)])
    log("results", ["atomically", result.successful, result.reason])
    node.remove_on_set_parameters_callback(check)
    log("results", ["without a limit", node.set_parameters([Parameter("speed", value=9.0)])[0].successful])
    names = ("speed", "limit", "echo")
    log("values", [node.get_parameter(name).value for name in names])


def overridden(log: Log) -> None:
    """Values from the command line, for all nodes and for one, also those that are not declared."""
    arguments = ["--ros-args", "-p", "speed:=2", "-p", "right:speed:=3", "-p", "names:=[a, b]", "-p", "use:=true"]
    rclpy.init(args=[*arguments, "-p", "sleep:=1e-3", "-p", "deep.er:=x", "-p", "empty:=''"])
    for name, options in (
        ("left", {}),
        ("right", {"allow_undeclared_parameters": True}),
        ("all", {"automatically_declare_parameters_from_overrides": True}),
        ("own", {"parameter_overrides": [Parameter("speed", value=4)]}),
    ):
        node = Node(name, **options)
        log(name, ["has", node.has_parameter("speed"), node.has_parameter("deep.er")])
        if not node.has_parameter("speed"):
            log(name, ["speed", node.declare_parameter("speed", 1).value])
        ignoring = raised(lambda node=node: node.declare_parameter("use", False, ignore_override=True))
        log(name, ["ignoring", ignoring, node.get_parameter("use").value])
        for parameter, default in (("names", ["c"]), ("sleep", 1.0), ("empty", "full")):
            if not node.has_parameter(parameter):
                log(name, [parameter, node.declare_parameter(parameter, default).value])
        log(name, ["wrong type", raised(lambda node=node: node.declare_parameter("deep.er", 1))])
        log(name, ["prefix", {key: each.value for key, each in node.get_parameters_by_prefix("deep").items()}])
        log(name, ["set", raised(lambda node=node: node.set_parameters([Parameter("new", value=1)]))])


SYSTEMS = {
    "parameters": System({"configuring": configuring}, {"configurable": serving(configurable)}),
    "services of parameters": System({"asking": asking}, {"many": serving(many)}),
    "callbacks of parameters": alone(called_back),
    "parameters from arguments": alone(overridden),
}
