"""The replacement of `rclpy._rclpy_pybind11`: all its names, implemented by the modules of this package.

`extension` makes the module; `overlay.replace_extension` enters it in `sys.modules` before `rclpy` is imported.
"""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Callable
from enum import IntEnum
from pathlib import Path
from types import ModuleType
from typing import Any

from pytest_hricdv.extra.ros2 import (
    actions,
    arguments,
    clocks,
    contexts,
    events,
    graph,
    handles,
    lifecycle,
    logging,
    messages,
    names,
    qos,
)
from pytest_hricdv.extra.ros2.executor import events_executor
from pytest_hricdv.extra.ros2.services import Client, IntrospectionState, RequestId, ServiceInfo, ServiceServer
from pytest_hricdv.extra.ros2.topics import Publisher, TopicSubscription
from pytest_hricdv.extra.ros2.wait_set import GuardCondition, WaitSet

NAME = "rclpy._rclpy_pybind11"

_EVENTS_EXECUTOR = "EventsExecutor"


class SignalHandlerOptions(IntEnum):
    """The signals that `rclpy` asks to handle, numbered as in its extension."""

    NO = 0
    SIGINT = 1
    SIGTERM = 2
    ALL = 3


_SIGNAL_HANDLERS = "ros2 signal handlers"


class TypeDescriptionService(handles.Destroyable):
    """The service that returns the definitions of a node's types. It knows none: only generated classes are loaded."""

    def __init__(self, node: contexts.GraphNode) -> None:
        super().__init__(node.kernel)
        from type_description_interfaces.srv import (  # type: ignore[import-not-found, unused-ignore]
            GetTypeDescription,
        )

        name = f"{node.get_fully_qualified_name()}/get_type_description"
        self.impl = ServiceServer(node, GetTypeDescription, name, qos.Profile())

    def handle_request(self, request: Any, response_type: type[Any], node: contexts.GraphNode) -> Any:
        """Answer that it is not known."""
        response = response_type()
        response.successful = False
        response.failure_reason = "type descriptions are not simulated"
        return response

    def destroy(self) -> None:
        """Serve no more."""
        self.impl.destroy_when_not_in_use()


_ARGUMENTS_OF_JAZZY = 6
"""Number of arguments of a node; since kilted, the profile of its log is one more."""


class RosoutNode(contexts.GraphNode):
    """A node whose log is published on `/rosout`, and that can be asked for the actions in the graph.

    Its log is what its logger, and those below it, log. It is not published where `enable_rosout` or the arguments of
    its context say so.
    """

    get_action_names_and_types = graph.actions
    get_action_client_names_and_types_by_node = graph.action_clients_by_node
    get_action_server_names_and_types_by_node = graph.action_servers_by_node

    def __init__(self, *arguments: Any) -> None:
        *common, profile = arguments if len(arguments) > _ARGUMENTS_OF_JAZZY else (*arguments, None)
        super().__init__(*common)
        self._publisher: Publisher | None = None
        if self.enable_rosout and self.context.arguments.rosout:
            from rcl_interfaces.msg import Log  # type: ignore[import-not-found, unused-ignore]

            self._kind = Log
            self._publisher = Publisher(self, Log, "/rosout", profile or qos.PREDEFINED["qos_profile_rosout_default"])
            logging.log_of(self.kernel).listeners.setdefault(self.logger_name(), []).append(self._publish)

    def _publish(self, entry: logging.LogEntry) -> None:
        assert self._publisher is not None
        message = self._kind(level=int(entry.severity), name=entry.logger, msg=entry.text)
        message.function, message.file, message.line = entry.function, Path(entry.file).name, entry.line
        messages.set_stamp(message.stamp, clocks.system_ns(self.kernel))
        self._publisher.publish(message)

    def leave(self) -> None:
        """Be found in the graph no more; nothing of its log is published."""
        if self._publisher is not None:
            self._publisher.destroy_when_not_in_use()
            listeners = logging.log_of(self.kernel).listeners
            for name, callbacks in listeners.items():
                listeners[name] = [callback for callback in callbacks if callback != self._publish]
        super().leave()


def _no_op(*_: object) -> None:
    """A function without effect in a simulated run."""


_SAME_NAMES = (
    *(handles.Destroyable, handles.RCLError, handles.InvalidHandle, contexts.Context, GuardCondition, WaitSet),
    *(Publisher, Client, actions.ActionClient, actions.ActionServer, actions.ActionGoalHandle, actions.GoalEvent),
    *(clocks.Clock, clocks.ClockType, clocks.ClockChange, clocks.ClockEvent, clocks.TimerCancelledError),
    *(events.EventHandle, events.UnsupportedEventTypeError, qos.QoSCompatibility, lifecycle.LifecycleStateMachine),
    *(TypeDescriptionService, SignalHandlerOptions, graph.NodeNameNonExistentError, arguments.UnknownROSArgsError),
)

_CLASSES: dict[str, Any] = {
    **{kind.__name__: kind for kind in _SAME_NAMES},
    "Node": RosoutNode,
    "Subscription": TopicSubscription,
    "Service": ServiceServer,
    "Timer": clocks.RosTimer,
    "rmw_service_info_t": ServiceInfo,
    "rmw_request_id_t": RequestId,
    "rcl_time_point_t": clocks.TimePoint,
    "rcl_duration_t": clocks.Duration,
    "rmw_qos_profile_t": qos.RmwProfile,
    "rmw_qos_policy_kind_t": qos.QosPolicyKind,
    "_rmw_qos_profile_dict": dict,
    "_TopicEndpointInfoDict": dict,
    "QoSCheckCompatibleResult": qos.CompatibilityResult,
    "rcl_publisher_event_type_t": events.PublisherEventType,
    "rcl_subscription_event_type_t": events.SubscriptionEventType,
    **{
        f"rmw_{name}_status_t": events.CountStatus
        for name in (
            *("requested_deadline_missed", "offered_deadline_missed", "message_lost", "liveliness_lost"),
            "incompatible_type",
        )
    },
    "rmw_liveliness_changed_status_t": events.LivelinessChangedStatus,
    "rmw_requested_qos_incompatible_event_status_t": events.QosIncompatibleStatus,
    "rmw_offered_qos_incompatible_event_status_t": events.QosIncompatibleStatus,
    "rmw_matched_status_t": events.MatchedStatus,
    "TransitionCallbackReturnType": lifecycle.CallbackReturn,
    "RCUTILS_LOG_SEVERITY": logging.Severity,
    "RCUtilsError": RuntimeError,
    "RMWError": RuntimeError,
    "RCLInvalidROSArgsError": arguments.InvalidROSArgsError,
    "NotImplementedError": NotImplementedError,
}

_CONSTANTS: dict[str, object] = {
    "RCL_DEFAULT_DOMAIN_ID": contexts.DEFAULT_DOMAIN,
    "RMW_DURATION_INFINITE": qos.INFINITE_NS,
    "RMW_QOS_DEADLINE_BEST_AVAILABLE": qos.BEST_AVAILABLE_NS,
    "RMW_QOS_LIVELINESS_LEASE_DURATION_BEST_AVAILABLE": qos.BEST_AVAILABLE_NS,
}


def _resolve(node: contexts.GraphNode, name: str, only_expand: bool, is_service: bool) -> str:
    try:
        if only_expand:
            return names.expand(name, node.get_node_name(), node.get_namespace())
        return node.resolve(name)
    except ValueError as error:
        raise handles.RCLError(f"failed to resolve name: {error}") from None


def _signal_handlers() -> SignalHandlerOptions:
    option = handles.current_kernel("rclpy.signals").own.get(_SIGNAL_HANDLERS, SignalHandlerOptions.NO)
    assert isinstance(option, SignalHandlerOptions)
    return option


def _install_signal_handlers(options: SignalHandlerOptions = SignalHandlerOptions.NO) -> None:
    """Note what was asked for: signals are the test runner's, and code under test gets none."""
    handles.current_kernel("rclpy.signals").own[_SIGNAL_HANDLERS] = options


_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "rclpy_remove_ros_args": arguments.without_ros,
    "rclpy_get_rmw_implementation_identifier": lambda: "pytest_hricdv",
    "rclpy_expand_topic_name": names.expand,
    "rclpy_resolve_name": _resolve,
    "rclpy_remap_topic_name": contexts.GraphNode.remap,
    "rclpy_get_validation_error_for_topic_name": names.topic_name_fault,
    "rclpy_get_validation_error_for_full_topic_name": names.full_topic_name_fault,
    "rclpy_get_validation_error_for_namespace": names.namespace_fault,
    "rclpy_get_validation_error_for_node_name": names.node_name_fault,
    "rclpy_get_topic_names_and_types": graph.topic_names_and_types,
    "rclpy_get_service_names_and_types": graph.service_names_and_types,
    "rclpy_get_publisher_names_and_types_by_node": graph.publishers_by_node,
    "rclpy_get_subscriber_names_and_types_by_node": graph.subscribers_by_node,
    "rclpy_get_service_names_and_types_by_node": graph.services_by_node,
    "rclpy_get_client_names_and_types_by_node": graph.clients_by_node,
    "rclpy_get_publishers_info_by_topic": graph.publishers_info,
    "rclpy_get_subscriptions_info_by_topic": graph.subscriptions_info,
    "rclpy_qos_check_compatible": qos.check_compatible,
    "rclpy_action_get_rmw_qos_profile": lambda name: qos.ACTION_STATUS.to_dict(),
    "rclpy_serialize": messages.serialize,
    "rclpy_deserialize": messages.deserialize,
    "rclpy_assert_liveliness": Publisher.assert_liveliness,
    "rclpy_logging_initialize": logging.reset_levels,
    "rclpy_logging_shutdown": logging.reset_levels,
    "rclpy_logging_configure": logging.configure,
    "rclpy_logging_fini": _no_op,
    "rclpy_logging_get_separator_string": lambda: logging.SEPARATOR,
    "rclpy_logging_set_logger_level": logging.set_logger_level,
    "rclpy_logging_get_logger_level": logging.logger_level,
    "rclpy_logging_get_logger_effective_level": logging.effective_level,
    "rclpy_logging_logger_is_enabled_for": logging.is_enabled_for,
    "rclpy_logging_severity_level_from_string": logging.level_from_string,
    "rclpy_logging_get_logging_directory": lambda: os.path.join(os.path.expanduser("~"), ".ros", "log"),
    "rclpy_logging_rcutils_log": logging.write,
    "rclpy_logging_rosout_add_sublogger": logging.add_sublogger,
    "rclpy_logging_rosout_remove_sublogger": logging.remove_sublogger,
    "register_sigint_guard_condition": _no_op,
    "unregister_sigint_guard_condition": _no_op,
    "install_signal_handlers": _install_signal_handlers,
    "uninstall_signal_handlers": _install_signal_handlers,
    "get_current_signal_handlers_options": _signal_handlers,
}


def extension() -> ModuleType:
    """The module. A name that it lacks is an error that says so, when it is used."""
    made = ModuleType(NAME, __doc__)
    introspection = ModuleType(f"{NAME}.service_introspection")
    vars(introspection)["ServiceIntrospectionState"] = IntrospectionState
    vars(made).update({**_CLASSES, **_CONSTANTS, **_FUNCTIONS, "service_introspection": introspection})

    # A newer distribution may use other names: the error then names them.
    def find_name(name: str) -> Any:
        if name == _EVENTS_EXECUTOR:  # a class below one of rclpy's, which is imported after its extension
            vars(made)[name] = events_executor(importlib.import_module("rclpy.executors"))
            return vars(made)[name]
        raise AttributeError(f"{name} of rclpy's extension is not simulated yet")

    vars(made)["__getattr__"] = find_name
    for name in [name for name in sys.modules if name.startswith(f"{__package__}.")]:
        vars(sys.modules[name])["__tracebackhide__"] = True  # a failing test shows the frames of its author
    return made
