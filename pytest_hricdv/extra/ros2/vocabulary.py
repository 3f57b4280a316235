"""What requirements can name of a ROS 2 system that a testbench declares, with the types of the fields."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from typing import Any

from pytest_hricdv._base.suggestion import nearest
from pytest_hricdv.declarations.ros2 import Ros2, Ros2Error
from pytest_hricdv.extra.ros2.delivery import check_timing
from pytest_hricdv.extra.ros2.interface_packages import provide_interfaces
from pytest_hricdv.extra.ros2.messages import kinds_of
from pytest_hricdv.monitor.names import Kind
from pytest_hricdv.runtime.source_location import raised_at

ROSOUT = "rosout"

_TERMINAL = "terminal_input"
"""What `run.terminal` records when keys are pressed."""


def vocabulary(declared: Ros2) -> dict[str, dict[str, Kind]]:
    """What requirements can name of a declared system: name in requirements -> its fields with their types.

    Raises:
        Ros2Error: a name or type is none, or two have the same name in requirements.
    """
    provide_interfaces(declared.interfaces)
    check_timing(declared)
    names: dict[str, dict[str, Kind]] = {
        ROSOUT: {"level": float, "name": str, "msg": str},
        _TERMINAL: {"terminal": str, "text": str},
    }
    for name, kinds in _kinds(declared):
        if name in names:
            raise Ros2Error(f"ros2: two topics or services are called {name!r} in requirements; rename one of them")
        names[name] = kinds
    return names


def _kinds(declared: Ros2) -> Iterator[tuple[str, dict[str, Kind]]]:
    for full_name, kind in declared.topics.items():
        if full_name == f"/{ROSOUT}":
            raise Ros2Error(f"ros2: requirements know /{ROSOUT} without its being declared; leave it out")
        yield requirement_name(full_name), kinds_of(import_type(kind, "msg"))
    for full_name, kind in declared.services.items():
        name, service = requirement_name(full_name), import_type(kind, "srv")
        yield f"{name}_request", kinds_of(service.Request)
        yield f"{name}_response", kinds_of(service.Response)
    for full_name, kind in declared.actions.items():
        name, action = requirement_name(full_name), import_type(kind, "action")
        yield f"{name}_goal", kinds_of(action.Goal)
        yield f"{name}_answer", {"accepted": bool}
        yield f"{name}_feedback", kinds_of(action.Feedback)
        yield f"{name}_cancel", {}
        yield f"{name}_result", {"status": float, **kinds_of(action.Result)}


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


def import_type(name: str, folder: str) -> Any:
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
            raise Ros2Error(
                f"ros2: type {name!r}: {package} cannot be imported: {raised_at(error)} imports {error.name!r}, "
                "which is not installed; install it"
            ) from error
        raise Ros2Error(
            f"ros2: type {name!r}: there is no Python package {error.name!r}; is the workspace's setup file sourced? "
            "The folder of its interface files is enough: Ros2(interfaces=(...,))"
        ) from None
    try:
        return getattr(module, class_name)
    except AttributeError:
        classes = [member for member in dir(module) if member[0].isupper()]
        raise Ros2Error(f"ros2: {package} has no {folder} {class_name!r}{nearest(class_name, classes)}") from None
