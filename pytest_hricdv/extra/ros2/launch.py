"""How nodes that a testbench names are started: the command line of each one, and what its process calls."""

from __future__ import annotations

import importlib
import inspect
import math
import sys
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any

from pytest_hricdv._base.suggestion import nearest
from pytest_hricdv.declarations.ros2 import LaunchError, Ros2Error, RosNode
from pytest_hricdv.extra.ros2.packages import console_scripts, find_executable, is_binary
from pytest_hricdv.runtime.source_location import error_line

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all


def command_line(node: RosNode) -> list[str]:
    """`sys.argv` of the process of a node.

    Raises:
        LaunchError: a parameter that ROS has no type for.
    """
    rules = [("__node", node.name), ("__ns", node.namespace)]
    remapped = [f"{source}:={target}" for source, target in [*rules, *node.remappings] if target]
    ros = [word for rule in remapped for word in ("-r", rule)]
    for parameters in node.parameters:
        if isinstance(parameters, Mapping):
            ros += [word for name, value in _flat(node, "", parameters) for word in ("-p", f"{name}:={value}")]
        else:
            ros += ["--params-file", str(parameters)]
    return [node.executable or node.label, *node.arguments, *(["--ros-args", *ros] if ros else [])]


def _flat(node: RosNode, above: str, parameters: Mapping[str, Any]) -> list[tuple[str, str]]:
    flat = []
    for name, value in parameters.items():
        if isinstance(value, Mapping):
            flat += _flat(node, f"{above}{name}.", value)
        else:
            flat.append((f"{above}{name}", yaml_text(node, f"{above}{name}", value)))
    return flat


def yaml_text(node: RosNode, name: str, value: Any) -> str:
    """A value of a parameter as a command line has it. Raises LaunchError for one that ROS has no type for."""
    if isinstance(value, bool):  # before int, which it is, too
        return str(value).lower()
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return _yaml_float(value)
    if isinstance(value, str):
        return "'" + value.replace("'", "''") + "'"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(yaml_text(node, name, element) for element in value) + "]"
    raise LaunchError(f"{node}: parameter {name!r} is {value!r}; expected a bool, a number, a text, or a list")


def entry_point(node: RosNode) -> str:
    """Where the code of a node is, "package.module:name".

    Raises:
        LaunchError: there is no such package or executable, or it is not written in Python.
    """
    if node.entry:
        return node.entry
    entries = console_scripts(node.package, {}) or {}
    if node.executable not in entries:
        raise _not_a_script(node, list(entries))
    return entries[node.executable]


def _not_a_script(node: RosNode, scripts: Sequence[str]) -> LaunchError:
    file = find_executable(node.package, node.executable)
    if file is not None and is_binary(file):
        return LaunchError(
            f"{node}: {file} is a compiled program, as of C++; nodes of rclpy can be run. Simulate what it does, "
            "with run.ros2(...).node(...), or with a node in Python"
        )
    if file is not None:
        return LaunchError(f'{node}: {file} is no entry point; name its function as entry="package.module:main"')
    problem = f"has {', '.join(sorted(scripts))}{nearest(node.executable, scripts)}"
    if not scripts:
        problem = "is not installed, or has none"
    return LaunchError(
        f"{node}: no console script of this name; package {node.package!r} {problem}. "
        'Source the workspace\'s setup file, or name the function as entry="package.module:main"'
    )


def require_virtual_package(what: str, entry: str, packages: Collection[str]) -> None:
    """Refuse an entry "package.module:name" whose package does not see virtual time.

    Raises:
        Ros2Error: its package is none of `packages`.
    """
    package = entry.partition(":")[0].partition(".")[0]
    if package not in packages:
        raise Ros2Error(
            f"{what}: its package {package!r} is neither in the testbench's code nor in Ros2(packages=...); add it "
            "there, so that it sees virtual time"
        )


def load(node: RosNode) -> Callable[[], object]:
    """Import the code of a node; what its process is to call.

    Raises:
        LaunchError: there is no such module, or no such name in it.
    """
    return load_entry(str(node), entry_point(node), command_line(node))


def load_entry(what: str, entry: str, argv: list[str]) -> Callable[[], object]:
    """Import a function, or a class of nodes; what its process is to call.

    Args:
        what: that is started, for messages.
        entry: "package.module:name".
        argv: command line of its process.

    Raises:
        LaunchError: there is no such module, or no such name in it.
    """
    module_name, colon, name = entry.partition(":")
    if not colon:
        raise LaunchError(f'{what}: expected "package.module:function", not {entry!r}')
    try:
        with _stand_ins_as_arguments():
            module = importlib.import_module(module_name)
    except ImportError as error:
        own = isinstance(error, ModuleNotFoundError) and error.name is not None
        if own and f"{module_name}.".startswith(f"{error.name}."):
            raise LaunchError(f"{what}: there is no module {error.name!r}; is its folder on the path?") from None
        raise LaunchError(f"{what}: {module_name} cannot be imported: {_import_error_text(error)}") from error
    target = vars(module).get(name)
    if not callable(target):
        callables = [member for member, value in vars(module).items() if callable(value) and not member.startswith("_")]
        raise LaunchError(f"{what}: {module_name} has no {name!r}{nearest(name, callables)}")
    return _spin_main(target) if isinstance(target, type) else _with_arguments(target, argv)


_OF_MESSAGES = ("_msgs", "_interfaces", "_srvs")
"""How names of packages of interfaces end, as a rule."""


def _import_error_text(error: ImportError) -> str:
    """Which import failed, where, and what to do."""
    where = error_line(error)
    if isinstance(error, ModuleNotFoundError) and error.name:
        missing = f"{where} imports {error.name!r}, which is not installed"
        files = "; of messages, the folder of their interface files is enough: Ros2(interfaces=(...,))"
        hint = files if error.name.endswith(_OF_MESSAGES) else ""
        return f"{missing}; install it, or source the workspace that has it{hint}"
    return f"{where}: {error}"


_STAND_INS = ["program", "arguments of its process"]
"""`sys.argv` while nodes are imported, so that defaults made of it are known: `def main(args=sys.argv[1:])`."""


@contextmanager
def _stand_ins_as_arguments() -> Iterator[None]:
    before, sys.argv = sys.argv, list(_STAND_INS)
    try:
        yield
    finally:
        sys.argv = before


def _with_arguments(main: Callable[..., object], command_line: list[str]) -> Callable[[], object]:
    """A main function, called with the arguments of its process where its defaults were made of `sys.argv`."""
    arguments = {}
    for name, parameter in inspect.signature(main).parameters.items():
        if parameter.default == _STAND_INS:
            arguments[name] = command_line
        elif parameter.default == _STAND_INS[1:]:
            arguments[name] = command_line[1:]
    return partial(main, **arguments)


def _spin_main(kind: Callable[[], Any]) -> Callable[[], object]:
    """What the main function of a node is, for a class of nodes."""

    def main() -> None:
        import rclpy  # type: ignore[import-not-found, unused-ignore]
        from rclpy.executors import ExternalShutdownException  # type: ignore[import-not-found, unused-ignore]

        rclpy.init()
        node = kind()
        try:
            rclpy.spin(node)
        except ExternalShutdownException:
            pass
        finally:
            node.destroy_node()
            rclpy.try_shutdown()

    return main


def _yaml_float(value: float) -> str:
    """As YAML 1.1 reads a float: with a point, and a sign in the exponent."""
    if not math.isfinite(value):
        return ".nan" if math.isnan(value) else ".inf" if value > 0 else "-.inf"
    mantissa, e, exponent = repr(value).partition("e")
    return (mantissa if "." in mantissa else f"{mantissa}.0") + (e + exponent if e else "")
