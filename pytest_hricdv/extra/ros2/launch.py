"""What is to be started of a ROS 2 system: nodes, named as the `Node` actions of a launch description name them."""

from __future__ import annotations

import importlib
import inspect
import math
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from importlib import metadata
from pathlib import Path
from typing import Any

from pytest_hricdv._base.message import InputError
from pytest_hricdv._base.suggestion import nearest

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

_ELF = b"\x7fELF"


class LaunchError(InputError):
    """A node cannot be started; the text says which, what was expected, and what to do."""


@dataclass(frozen=True)
class RosNode:
    """One process with a node, as `launch_ros.actions.Node` describes it.

    Args:
        package: of an executable, or empty where there is an entry.
        executable: a console script of the package.
        entry: instead of both, where its code is: "package.module:main" for a function without arguments, or
            "package.module:Class" for a class of nodes, which is made without arguments, and spun.
        name: the node's name instead of its own.
        namespace: it is in, such as "/arm".
        remappings: pairs of names, from and to.
        parameters: mappings of names to values, or paths of YAML files; later ones win.
        arguments: further ones of its command line.

    Raises:
        LaunchError: neither an executable nor an entry, or both.
    """

    package: str = ""
    executable: str = ""
    entry: str = ""
    name: str = ""
    namespace: str = ""
    remappings: Sequence[tuple[str, str]] = ()
    parameters: Sequence[Mapping[str, Any] | str | Path] = ()
    arguments: Sequence[str] = ()

    def __post_init__(self) -> None:
        if bool(self.entry) == bool(self.executable) or bool(self.package) != bool(self.executable):
            raise LaunchError(f'{self}: expected package="..." and executable="...", or entry="package.module:name"')

    def __str__(self) -> str:
        return f"RosNode {self.entry or f'{self.package} {self.executable}'}"

    @property
    def label(self) -> str:
        """What its process is called in messages."""
        module, _, function = self.entry.partition(":")
        return self.name or self.executable or (module.rpartition(".")[2] if function == "main" else function)

    def command_line(self) -> list[str]:
        """`sys.argv` of its process.

        Raises:
            LaunchError: a parameter that ROS has no type for.
        """
        rules = [("__node", self.name), ("__ns", self.namespace)]
        remapped = [f"{source}:={target}" for source, target in [*rules, *self.remappings] if target]
        ros = [word for rule in remapped for word in ("-r", rule)]
        for parameters in self.parameters:
            if isinstance(parameters, Mapping):
                ros += [word for name, value in self._flat("", parameters) for word in ("-p", f"{name}:={value}")]
            else:
                ros += ["--params-file", str(parameters)]
        return [self.executable or self.label, *self.arguments, *(["--ros-args", *ros] if ros else [])]

    def _flat(self, above: str, parameters: Mapping[str, Any]) -> list[tuple[str, str]]:
        flat = []
        for name, value in parameters.items():
            if isinstance(value, Mapping):
                flat += self._flat(f"{above}{name}.", value)
            else:
                flat.append((f"{above}{name}", self._yaml(f"{above}{name}", value)))
        return flat

    def _yaml(self, name: str, value: Any) -> str:
        if isinstance(value, bool):  # before int, which it is, too
            return str(value).lower()
        if isinstance(value, int):
            return str(value)
        if isinstance(value, float):
            return _yaml_float(value)
        if isinstance(value, str):
            return "'" + value.replace("'", "''") + "'"
        if isinstance(value, list | tuple):
            return "[" + ", ".join(self._yaml(name, element) for element in value) + "]"
        raise LaunchError(f"{self}: parameter {name!r} is {value!r}; expected a bool, a number, a text, or a list")

    def entry_point(self) -> str:
        """Where its code is, "package.module:name".

        Raises:
            LaunchError: there is no such package or executable, or it is not written in Python.
        """
        if self.entry:
            return self.entry
        try:
            scripts = metadata.distribution(self.package).entry_points.select(group="console_scripts")
        except metadata.PackageNotFoundError:
            raise self._not_a_script([]) from None
        entries = {script.name: script.value for script in scripts}
        if self.executable not in entries:
            raise self._not_a_script(list(entries))
        return entries[self.executable]

    def _not_a_script(self, scripts: Sequence[str]) -> LaunchError:
        file = _installed_executable(self.package, self.executable)
        if file is not None and file.read_bytes()[:4] == _ELF:
            return LaunchError(
                f"{self}: {file} is a compiled program, as of C++; nodes of rclpy can be run. Simulate what it does, "
                "with run.ros2(...).node(...), or with a node in Python"
            )
        if file is not None:
            return LaunchError(f'{self}: {file} is no entry point; name its function as entry="package.module:main"')
        problem = f"has {', '.join(sorted(scripts))}{nearest(self.executable, scripts)}"
        if not scripts:
            problem = "is not installed, or has none"
        return LaunchError(
            f"{self}: no console script of this name; package {self.package!r} {problem}. "
            'Source the workspace\'s setup file, or name the function as entry="package.module:main"'
        )

    def load(self) -> Callable[[], object]:
        """Import its code; what its process is to call.

        Raises:
            LaunchError: there is no such module, or no such name in it.
        """
        entry = self.entry_point()
        module_name, colon, name = entry.partition(":")
        if not colon:
            raise LaunchError(f'{self}: expected "package.module:function", not {entry!r}')
        try:
            with _stand_ins_as_arguments():
                module = importlib.import_module(module_name)
        except ModuleNotFoundError as error:
            if error.name is None or not (module_name == error.name or module_name.startswith(f"{error.name}.")):
                raise
            raise LaunchError(f"{self}: there is no module {error.name!r}; is its folder on the path?") from None
        target = vars(module).get(name)
        if not callable(target):
            callables = [
                member for member, value in vars(module).items() if callable(value) and not member.startswith("_")
            ]
            raise LaunchError(f"{self}: {module_name} has no {name!r}{nearest(name, callables)}")
        return _spinning(target) if isinstance(target, type) else _with_arguments(target, self.command_line())


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


def _spinning(kind: Callable[[], Any]) -> Callable[[], object]:
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


def _installed_executable(package: str, executable: str) -> Path | None:
    """The file that `ros2 run` would start; None if there is none, or no ROS installation."""
    try:
        from ament_index_python import get_package_prefix  # type: ignore[import-not-found, unused-ignore]

        file = Path(get_package_prefix(package)) / "lib" / package / executable
    except (ImportError, LookupError, OSError, ValueError):  # it wants a variable of the environment
        return None
    return file if file.is_file() else None


def _yaml_float(value: float) -> str:
    """As YAML 1.1 reads a float: with a point, and a sign in the exponent."""
    if not math.isfinite(value):
        return ".nan" if math.isnan(value) else ".inf" if value > 0 else "-.inf"
    mantissa, e, exponent = repr(value).partition("e")
    return (mantissa if "." in mantissa else f"{mantissa}.0") + (e + exponent if e else "")
