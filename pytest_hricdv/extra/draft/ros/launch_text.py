"""Reading launch files of XML and YAML without the launch system of ROS 2, as far as they are simple."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pytest_hricdv.extra.draft.found.launched import LaunchedNodes, StartedNode
from pytest_hricdv.extra.draft.found.place import Place
from pytest_hricdv.extra.draft.reading.sources import DraftError
from pytest_hricdv.extra.draft.ros.launch_elements import INSTALL, Entity, entities
from pytest_hricdv.extra.ros2.arguments import parse
from pytest_hricdv.extra.ros2.handles import RCLError
from pytest_hricdv.extra.ros2.packages import SourcePackage

DEEPEST = 16
"""Launch files in launch files, and substitutions in substitutions (chosen)."""

_SUBSTITUTION = re.compile(r"\$\(([\w-]+)((?:[^()$]|\$(?!\())*)\)")
"""An innermost one: `$(var name)`."""


class NotSimpleError(ValueError):
    """Something of a launch file needs the launch system; the text says what."""


def read_launch(file: Path, arguments: Mapping[str, str], packages: Mapping[str, SourcePackage]) -> LaunchedNodes:
    """What a launch file of XML or YAML starts.

    Raises:
        DraftError: it is of Python, or cannot be parsed; an argument has no value.
    """
    reader = _Reader(file, packages)
    scope = _Scope(dict(arguments), set(arguments))
    reader.read(file, scope, 0)
    return LaunchedNodes(file, arguments, tuple(reader.nodes), tuple(reader.problems))


@dataclass
class _Scope:
    """What an element is surrounded by.

    Args:
        variables: launch configurations, name -> value.
        handed: names of those that came from outside.
        namespace: that groups have pushed.
        remappings: of `set_remap`.
        parameters: of `set_parameter`.
    """

    variables: dict[str, str]
    handed: set[str] = field(default_factory=set)
    namespace: str = ""
    remappings: tuple[tuple[str, str], ...] = ()
    parameters: tuple[Mapping[str, Any] | str, ...] = ()

    def inner(self) -> _Scope:
        """Of a group."""
        return _Scope(dict(self.variables), set(self.handed), self.namespace, self.remappings, self.parameters)


class _Reader:
    """Follows a launch file and those that it includes."""

    def __init__(self, file: Path, packages: Mapping[str, SourcePackage]) -> None:
        self.nodes: list[StartedNode] = []
        self.problems: list[tuple[Place, str]] = []
        self._root, self._packages = file.parent, packages
        self._actions: dict[str, Callable[[Entity, _Scope, Path, int], None]] = {
            "arg": self._arg, "let": self._let, "node": self._node, "group": self._group, "include": self._include,
            "push_ros_namespace": self._push, "set_remap": self._set_remap, "set_parameter": self._set_parameter,
            "timer": self._parts, "executable": self._command, "lifecycle_node": self._node,
        }  # fmt: skip

    def read(self, file: Path, scope: _Scope, depth: int) -> None:
        """Follow a file."""
        if depth > DEEPEST:
            raise DraftError(f"--launch={file}: launch files include each other more than {DEEPEST} deep")
        self._parts(entities(file), scope, file, depth)

    def _parts(self, entity: Entity, scope: _Scope, file: Path, depth: int) -> None:
        for part in entity.parts:
            place = Place(os.path.relpath(file, self._root), part.line)
            try:
                if not self._is_meant(part, scope, file):
                    continue
                if part.kind in self._actions:
                    self._actions[part.kind](part, scope, file, depth)
                elif part.kind not in ("log", "set_env", "unset_env", "keep_alive", "env", "remap", "param"):
                    self.problems.append((place, f"<{part.kind}> is left out: {INSTALL}"))
            except NotSimpleError as error:
                self.problems.append((place, f"<{part.kind}> is left out: {error}"))

    def _is_meant(self, entity: Entity, scope: _Scope, file: Path) -> bool:
        for name, wanted in (("if", True), ("unless", False)):
            if name in entity.values:
                text = self._text(entity.values[name], scope, file).strip().lower()
                if text not in ("true", "1", "false", "0"):
                    raise NotSimpleError(f"{name}={text!r}: expected true or false")
                if (text in ("true", "1")) != wanted:
                    return False
        return True

    def _text(self, text: str, scope: _Scope, file: Path) -> str:
        """A text with its substitutions made."""
        for _ in range(DEEPEST):
            match = _SUBSTITUTION.search(text)
            if match is None:
                return text
            made = self._substitute(match[1].replace("_", "-"), match[2].strip(), scope, file)
            text = text[: match.start()] + made + text[match.end() :]
        return text

    def _substitute(self, kind: str, argument: str, scope: _Scope, file: Path) -> str:
        words = argument.split()
        if kind == "var" and words:
            name = argument.strip("'\"")
            if name not in scope.variables:
                raise NotSimpleError(f"$(var {name}) has no value here: give it as {name}:=VALUE, or declare it")
            return scope.variables[name]
        if kind in ("find-pkg-share", "find-pkg-prefix") and words:
            if words[0] in self._packages:
                return str(self._packages[words[0]].folder)
            raise NotSimpleError(f"package {words[0]!r} is not in the workspace around {file.parent}")
        if kind in ("env", "optenv") and words:
            value = os.environ.get(words[0], " ".join(words[1:]) if len(words) > 1 or kind == "optenv" else None)
            if value is None:
                raise NotSimpleError(f"the environment has no {words[0]}")
            return value
        if kind in ("dirname", "anon"):
            return str(file.parent) if kind == "dirname" else argument
        raise NotSimpleError(f"$({kind} ...): {INSTALL}")

    def _value(self, entity: Entity, name: str, scope: _Scope, file: Path, default: str = "") -> str:
        return self._text(entity.values.get(name, default), scope, file)

    def _arg(self, entity: Entity, scope: _Scope, file: Path, depth: int) -> None:
        name = self._value(entity, "name", scope, file)
        if name in scope.handed or name in scope.variables:
            return
        if "default" not in entity.values:
            raise DraftError(
                f"--launch={file}:{entity.line}: argument {name!r} has no default: "
                f'expected a value for it, --launch "{file.name} {name}:=VALUE"'
            )
        scope.variables[name] = self._value(entity, "default", scope, file)

    def _let(self, entity: Entity, scope: _Scope, file: Path, depth: int) -> None:
        scope.variables[self._value(entity, "name", scope, file)] = self._value(entity, "value", scope, file)

    def _push(self, entity: Entity, scope: _Scope, file: Path, depth: int) -> None:
        scope.namespace = _joined(scope.namespace, self._value(entity, "namespace", scope, file))

    def _set_remap(self, entity: Entity, scope: _Scope, file: Path, depth: int) -> None:
        scope.remappings += (
            (self._value(entity, "from", scope, file), self._value(entity, "to", scope, file)),
        )  # fmt: skip

    def _set_parameter(self, entity: Entity, scope: _Scope, file: Path, depth: int) -> None:
        scope.parameters += ({self._value(entity, "name", scope, file): self._scalar(entity, scope, file)},)

    def _scalar(self, entity: Entity, scope: _Scope, file: Path) -> Any:
        """A value as ROS reads one of a command line: `1` is a number, `2024-01-01` a text."""
        text = self._value(entity, "value", scope, file)
        try:
            return parse(["--ros-args", "-p", f"value:={text}"]).parameters[-1][2]
        except (RCLError, UnicodeError):
            return text

    def _group(self, entity: Entity, scope: _Scope, file: Path, depth: int) -> None:
        is_scoped = self._value(entity, "scoped", scope, file, "true").strip().lower() in ("true", "1")
        self._parts(entity, scope.inner() if is_scoped else scope, file, depth)

    def _include(self, entity: Entity, scope: _Scope, file: Path, depth: int) -> None:
        path = Path(self._value(entity, "file", scope, file))
        path = path if path.is_absolute() else file.parent / path
        inner = scope.inner()
        for part in entity.parts:
            if part.kind in ("arg", "let"):
                name = self._value(part, "name", scope, file)
                inner.variables[name] = self._value(part, "value", scope, file)
                inner.handed.add(name)
        if path.suffix == ".py":
            raise NotSimpleError(f"{path.name} is a launch file of Python: {INSTALL}")
        if not path.is_file():
            raise NotSimpleError(f"there is no file {path}")
        self.read(path, inner, depth + 1)

    def _command(self, entity: Entity, scope: _Scope, file: Path, depth: int) -> None:
        words = self._value(entity, "cmd", scope, file).split()
        if words:
            self.nodes.append(StartedNode("", words[0], self._place(entity, file)))

    def _place(self, entity: Entity, file: Path) -> Place:
        return Place(os.path.relpath(file, self._root), entity.line)

    def _node(self, entity: Entity, scope: _Scope, file: Path, depth: int) -> None:
        lacking = next((name for name in ("pkg", "exec") if name not in entity.values), None)
        if lacking is not None:
            hint = ": is it a launch file of ROS 1?" if "type" in entity.values else ""
            raise NotSimpleError(f"it has no {lacking}{hint}")
        remappings, parameters = list(scope.remappings), list(scope.parameters)
        for part in entity.parts:
            if not self._is_meant(part, scope, file):
                continue
            if part.kind == "remap":
                remappings.append((self._value(part, "from", scope, file), self._value(part, "to", scope, file)))
            elif part.kind == "param":
                parameters += self._parameters(part, scope, file)
        namespace = _joined(scope.namespace, self._value(entity, "namespace", scope, file))
        self.nodes.append(
            StartedNode(
                self._value(entity, "pkg", scope, file), self._value(entity, "exec", scope, file),
                self._place(entity, file), self._value(entity, "name", scope, file), namespace, tuple(remappings),
                tuple(parameters), tuple(self._value(entity, "args", scope, file).split()),
            )
        )  # fmt: skip

    def _parameters(self, entity: Entity, scope: _Scope, file: Path) -> Iterator[Mapping[str, Any] | str]:
        """A parameter, those below a name (`arm.speed`), or a file of them."""
        if "from" in entity.values:
            yield self._value(entity, "from", scope, file)
            return
        name = self._value(entity, "name", scope, file)
        inner = [part for part in entity.parts if part.kind == "param"]
        if not inner:
            yield {name: self._scalar(entity, scope, file)}
        for part in inner:
            for below in self._parameters(part, scope, file):
                if not isinstance(below, str):
                    yield {f"{name}.{key}": value for key, value in below.items()}


def _joined(namespace: str, name: str) -> str:
    """A namespace in another one; one that begins with a slash stands for itself."""
    if not name or name.startswith("/"):
        return name or namespace
    return f"{namespace.rstrip('/')}/{name}"
