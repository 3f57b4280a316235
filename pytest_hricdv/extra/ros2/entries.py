"""`load_entry`: imports the entry "package.module:name" of a node, and returns the function that its process calls.

`executables` calls it for a declared `RosNode`, and `launch_processes` for the nodes of launch files.
"""

from __future__ import annotations

import importlib
import inspect
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

from pytest_hricdv._base.message import nearest
from pytest_hricdv.declarations.ros2 import LaunchError
from pytest_hricdv.runtime.blocking_calls import HAS_TERMINALS
from pytest_hricdv.runtime.kernel import current_node
from pytest_hricdv.runtime.source_location import error_line

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all


def load_entry(what: str, entry: str, argv: list[str]) -> Callable[[], object]:
    """Import a function, or a class of nodes. Returns the main function of its process, without parameters.

    Args:
        what: what is started, for messages.
        entry: "package.module:name".
        argv: command line of its process.

    Raises:
        LaunchError: there is no such module, or no such name in it.
    """
    module_name, colon, name = entry.partition(":")
    if not colon:
        raise LaunchError(f'{what}: expected "package.module:function", not {entry!r}')
    try:
        with _placeholder_arguments(), _placeholder_terminal():
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
"""Usual ends of the names of interface packages."""


def _import_error_text(error: ImportError) -> str:
    """A text on which import failed, where, and what to do."""
    where = error_line(error)
    if isinstance(error, ModuleNotFoundError) and error.name:
        missing = f"{where} imports {error.name!r}, which is not installed"
        files = "; of messages, the folder of their interface files is enough: Ros2(interfaces=(...,))"
        hint = files if error.name.endswith(_OF_MESSAGES) else ""
        return f"{missing}; install it, or source the workspace that has it{hint}"
    return f"{where}: {error}"


_PLACEHOLDERS = ["program", "arguments of its process"]
"""`sys.argv` while nodes are imported, so that defaults made of it are known: `def main(args=sys.argv[1:])`."""


@contextmanager
def _placeholder_arguments() -> Iterator[None]:
    before, sys.argv = sys.argv, list(_PLACEHOLDERS)
    try:
        yield
    finally:
        sys.argv = before


@contextmanager
def _placeholder_terminal() -> Iterator[None]:
    """Let a module keep the settings of its terminal while it is imported: `settings = termios.tcgetattr(sys.stdin)`.

    They are those that the terminals of nodes begin with.
    """
    if not HAS_TERMINALS:
        yield
        return
    import termios

    from pytest_hricdv.runtime.virtual.terminal_keys import default_attributes

    before = termios.tcgetattr

    def tcgetattr(file: Any) -> list[Any]:
        is_input = file is sys.stdin or file == 0
        return default_attributes() if is_input and current_node() is None else before(file)

    termios.tcgetattr = tcgetattr
    try:
        yield
    finally:
        termios.tcgetattr = before


def _with_arguments(main: Callable[..., object], command_line: list[str]) -> Callable[[], object]:
    """A main function, called with the arguments of its process where its defaults were made of `sys.argv`."""
    arguments = {}
    for name, parameter in inspect.signature(main).parameters.items():
        if parameter.default == _PLACEHOLDERS:
            arguments[name] = command_line
        elif parameter.default == _PLACEHOLDERS[1:]:
            arguments[name] = command_line[1:]
    return partial(main, **arguments)


def _spin_main(kind: Callable[[], Any]) -> Callable[[], object]:
    """The main function for a class of nodes."""

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
