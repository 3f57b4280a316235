"""The nodes that a launch file starts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pytest_hricdv.extra.draft.found.place import Place


@dataclass(frozen=True)
class StartedNode:
    """A process that a launch file starts.

    Args:
        package: of its executable; empty for a command that is no node.
        executable: its name; of a command its first word.
        place: in the launch file; line 0 where it is not known.
        name: of its node; empty where it keeps its own.
        namespace: likewise.
        remappings: pairs of names, from and to.
        parameters: mappings of names to values, and paths of YAML files; later ones win.
        arguments: of its command line.
    """

    package: str
    executable: str
    place: Place
    name: str = ""
    namespace: str = ""
    remappings: tuple[tuple[str, str], ...] = ()
    parameters: tuple[Mapping[str, Any] | str, ...] = ()
    arguments: tuple[str, ...] = ()

    @property
    def key(self) -> str:
        """As `Launch.executables` calls it."""
        return f"{self.package}/{self.executable}" if self.package else self.executable


@dataclass(frozen=True)
class LaunchedNodes:
    """What a launch file starts.

    Args:
        file: its path.
        arguments: with which it was read, name -> value.
        nodes: in the order in which they are started.
        problems: what could not be read of it, a sentence each, with its place.
        is_run: whether the launch system read it; a draft then starts the file itself.
    """

    file: Path
    arguments: Mapping[str, str]
    nodes: tuple[StartedNode, ...]
    problems: tuple[tuple[Place, str], ...] = ()
    is_run: bool = False
