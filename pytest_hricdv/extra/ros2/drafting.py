"""ROS 2 knowledge for drafts of testbenches: packages and console scripts."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from pytest_hricdv.extra.ros2.packages import SourcePackage, console_scripts, packages_around, sources_in


class Ros2Tools:
    """See `pytest_hricdv.extra.draft.ros.executable`, whose protocol this is."""

    def packages(self, *folders: Path) -> dict[str, Path]:
        """Packages around folders and in them: name -> folder."""
        packages: dict[str, Path] = {}
        for folder in folders:
            for package in (*packages_around(folder / "package.xml").values(), *sources_in(folder)):
                packages.setdefault(package.name, package.folder)
        return packages

    def console_scripts(self, package: str, packages: Mapping[str, Path]) -> dict[str, str] | None:
        """Name -> "package.module:function"; None for a package that is neither source nor installed."""
        return console_scripts(package, {name: SourcePackage(name, folder) for name, folder in packages.items()})


ROS_TOOLS = Ros2Tools()
"""The tools for drafts."""
