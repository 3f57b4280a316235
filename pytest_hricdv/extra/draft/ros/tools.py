"""ROS 2 functions for drafts of nodes, which the feature `ros2` offers if it is installed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol, cast

from pytest_hricdv.extra.draft.code.sources import DraftError
from pytest_hricdv.registry import offers


class RosTools(Protocol):
    """Packages are mappings of names to folders with a package.xml."""

    def packages(self, *folders: Path) -> dict[str, Path]:
        """Packages around folders and in them."""

    def console_scripts(self, package: str, packages: Mapping[str, Path]) -> dict[str, str] | None:
        """Name -> "package.module:function", of a package as source or installed; None if there is neither."""

    def expand(self, name: str, node: str, namespace: str) -> str:
        """The full name of a topic, service or action. Raises ValueError for what is no name."""

    def launch(self, file: Path, arguments: Mapping[str, str]) -> list[dict[str, Any]] | None:
        """The processes that a launch file starts, as the launch system runs it; None if this is not installed.

        Each has the keys of `StartedNode`, without the location. Raises InputError if it refuses the file.
        """


def ros_tools() -> RosTools:
    """The tools. Raises DraftError if there is no feature `ros2`."""
    offered = offers("drafting", "ROS_TOOLS")
    if not offered:
        raise DraftError("nodes of ROS 2 need the feature `ros2`, which this installation does not have")
    return cast(RosTools, offered[0])
