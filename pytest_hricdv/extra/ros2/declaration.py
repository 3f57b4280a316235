"""What a testbench says of its ROS 2 system: the topics, services and actions that requirements name."""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from pytest_hricdv._base.message import InputError
from pytest_hricdv._base.suggestion import nearest
from pytest_hricdv.extra.ros2.fields import kinds_of

Kind = type[bool] | type[float] | type[str]


class Ros2Error(InputError):
    """What a testbench says of ROS 2 is wrong; the text says what, and what was expected."""


@dataclass(frozen=True)
class Ros2:
    """The ROS 2 system of a testbench. Types are named as ROS names them: "sensor_msgs/msg/LaserScan".

    In requirements, a topic has its full name without the first slash, with "_" for the others: "/arm/state" is
    `arm_state`, and its fields `arm_state.pose.position.x`. Of an array there is the length, `arm_state.name.length`.
    A service "/grasp" is the topics `grasp_request` and `grasp_response`; an action "/fetch" is `fetch_goal`,
    `fetch_answer` (field `accepted`), `fetch_feedback`, `fetch_cancel` and `fetch_result` (with `status`). What nodes
    log is `rosout`, with `name`, `level` and `msg`, without being declared.

    Args:
        topics: full name -> type of its messages.
        services: full name -> type.
        actions: full name -> type.
        packages: of nodes that are not under test; they see virtual time, too.
        patience_s: how long a node may have waited when a run ends, in a callback without a time-out, or for a service
            that nobody serves.
    """

    topics: Mapping[str, str] = field(default_factory=dict, hash=False)
    services: Mapping[str, str] = field(default_factory=dict, hash=False)
    actions: Mapping[str, str] = field(default_factory=dict, hash=False)
    packages: tuple[str, ...] = ()
    patience_s: float = 30.0

    def vocabulary(self) -> dict[str, dict[str, Kind]]:
        """Name in requirements -> its fields with their types.

        Raises:
            Ros2Error: a name or type is none, or two have the same name in requirements.
        """
        vocabulary: dict[str, dict[str, Kind]] = {ROSOUT: {"level": float, "name": str, "msg": str}}
        for name, kinds in self._kinds():
            if name in vocabulary:
                raise Ros2Error(f"ros2: two topics or services are called {name!r} in requirements; rename one of them")
            vocabulary[name] = kinds
        return vocabulary

    def _kinds(self) -> Iterator[tuple[str, dict[str, Kind]]]:
        for full_name, kind in self.topics.items():
            if full_name == f"/{ROSOUT}":
                raise Ros2Error(f"ros2: requirements know /{ROSOUT} without its being declared; leave it out")
            yield requirement_name(full_name), kinds_of(loaded(kind, "msg"))
        for full_name, kind in self.services.items():
            name, service = requirement_name(full_name), loaded(kind, "srv")
            yield f"{name}_request", kinds_of(service.Request)
            yield f"{name}_response", kinds_of(service.Response)
        for full_name, kind in self.actions.items():
            name, action = requirement_name(full_name), loaded(kind, "action")
            yield f"{name}_goal", kinds_of(action.Goal)
            yield f"{name}_answer", {"accepted": bool}
            yield f"{name}_feedback", kinds_of(action.Feedback)
            yield f"{name}_cancel", {}
            yield f"{name}_result", {"status": float, **kinds_of(action.Result)}


ROSOUT = "rosout"


def requirement_name(full_name: str) -> str:
    """What a topic, service or action is called in requirements.

    Raises:
        Ros2Error: the name is not full.
    """
    if not full_name.startswith("/") or len(full_name) < 2:
        raise Ros2Error(f'ros2: {full_name!r} is no full name; expected one with "/" in front, such as "/arm/state"')
    return full_name[1:].replace("/", "_")


_EXAMPLES = {
    "msg": ("topics", "std_msgs/msg/String"),
    "srv": ("services", "std_srvs/srv/Trigger"),
    "action": ("actions", "my_robot/action/Fetch"),
}
"""Folder of a package -> what its types are of, and one of them."""


def loaded(name: str, folder: str) -> Any:
    """The class of a type such as "std_msgs/msg/String".

    Args:
        folder: what it is: "msg", "srv" or "action".

    Raises:
        Ros2Error: the name is none of such a type, or its package is not installed.
    """
    package, _, rest = name.partition("/")
    found_folder, _, class_name = rest.partition("/")
    if found_folder != folder or not class_name:
        role, example = _EXAMPLES[folder]
        raise Ros2Error(f"ros2: {role} has the type {name!r}; expected one such as {example!r}")
    try:
        module = importlib.import_module(f"{package}.{folder}")
    except ModuleNotFoundError as error:
        if error.name not in (package, f"{package}.{folder}"):
            raise
        raise Ros2Error(
            f"ros2: type {name!r}: there is no Python package {error.name!r}; is the workspace's setup file sourced?"
        ) from None
    if class_name not in vars(module):
        classes = [member for member in vars(module) if member[0].isupper()]
        raise Ros2Error(f"ros2: {package} has no {folder} {class_name!r}{nearest(class_name, classes)}")
    return vars(module)[class_name]
