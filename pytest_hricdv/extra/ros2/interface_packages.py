"""Imports interface packages that are not installed, from the folders of their interface files.

`vocabulary` in `bridge` calls `provide_interfaces` with the folders that a testbench declares, `Ros2(interfaces=...)`.
`import my_msgs.msg` then finds a module whose classes `interface_classes` generates.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from types import ModuleType
from typing import Any

from pytest_hricdv.declarations.ros2 import Ros2Error
from pytest_hricdv.extra.ros2.interface_classes import FOLDERS, class_of_file


class _FolderModule(ModuleType):
    """`package.msg`, `package.srv` or `package.action`: a class is made when it is first asked for."""

    def __init__(self, name: str, folder: Path) -> None:
        super().__init__(name)
        self.__folder = folder

    def __dir__(self) -> list[str]:
        return sorted({file.stem for file in self.__folder.iterdir()} | vars(self).keys())

    def __getattr__(self, name: str) -> Any:
        package, _, kind = self.__name__.partition(".")
        base, _, nested = name.partition("_")  # `Fetch_Goal`, as `rosidl` names parts
        file = self.__folder / f"{base}.{kind}"
        if name.startswith("__") or not file.is_file():
            raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")
        made = class_of_file(file, package, kind)
        setattr(self, base, made)
        for part_name, part in _parts(made, base):
            setattr(self, part_name, part)
        return vars(self)[name] if nested else made


def _parts(made: Any, base: str) -> Iterator[tuple[str, Any]]:
    for owner in (made, getattr(made, "Impl", None)):
        for value in vars(owner).values() if owner is not None else ():
            if isinstance(value, type) and value.__name__.startswith(f"{base}_"):
                yield value.__name__, value
                yield from _parts(value, value.__name__)


class _InterfaceFinder:
    """Finds packages of interface files, unless they are installed."""

    def __init__(self) -> None:
        self.folders: dict[str, Path] = {}
        """Package -> its folder."""

    def find_spec(self, name: str, path: Sequence[str] | None = None, target: object = None) -> ModuleSpec | None:
        package, _, kind = name.partition(".")
        folder = self.folders.get(package)
        if folder is None or not (folder / kind).is_dir() or not self._is_ours(package, kind):
            return None
        return ModuleSpec(name, self, is_package=not kind)  # type: ignore[arg-type]  # it has what a loader needs

    def _is_ours(self, package: str, kind: str) -> bool:
        """Whether no package of this name is installed. Its folder of interface files, on the path, is not a package.

        A package of code that has interface files, too, is imported as it is: only these parts of it are ours.
        """
        if kind:
            loaded = sys.modules.get(package)
            if loaded is None or getattr(loaded.__spec__, "loader", None) is self:
                return loaded is not None
            built = PathFinder.find_spec(f"{package}.{kind}", getattr(loaded, "__path__", None))
            return built is None or built.origin is None
        installed = PathFinder.find_spec(package)
        return installed is None or installed.origin is None

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        package, _, kind = spec.name.partition(".")
        return _FolderModule(spec.name, self.folders[package] / kind) if kind else ModuleType(spec.name)

    def exec_module(self, module: ModuleType) -> None:
        """Nothing to execute: classes are made when they are asked for."""


_FINDER = _InterfaceFinder()


def provide_interfaces(folders: Sequence[str | Path]) -> None:
    """Let the packages whose interface files are in these folders be imported, unless they are installed.

    Args:
        folders: each of one package, with a folder "msg", "srv" or "action", and named as it.

    Raises:
        Ros2Error: a folder is none of a package of interfaces.
    """
    if folders and _FINDER not in sys.meta_path:
        sys.meta_path.insert(0, _FINDER)
    for named in folders:
        folder = Path(named).resolve()
        if not any((folder / kind).is_dir() for kind in FOLDERS):
            raise Ros2Error(
                f"ros2: interfaces: {named} has no folder msg, srv or action; expected the folder of a package, as of "
                "a checkout of its sources, such as third_party/nav2_msgs"
            )
        _FINDER.folders[folder.name] = folder
