"""Packages as sources: where they are, and which console scripts they declare."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.declarations.ros2 import Launch, LaunchError
from pytest_hricdv.extra.ros2.executables import Executables, command
from pytest_hricdv.extra.ros2.packages import SourcePackage, packages_around
from tests.extra.ros2.launch_workspace import write_manifest, write_package


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("setup.py", 'setup(entry_points={"console_scripts": ["arm = cell.arm:main"]})'),
        ("setup.py", 'n = "cell"\nsetup(entry_points={"console_scripts": [f"arm = {n}.arm:main"]})'),
        ("setup.py", 'n = "cell"\nsetup(entry_points={"console_scripts": ["arm = " + n + ".arm:main"]})'),
        ("setup.py", 'setup(entry_points=dict(console_scripts=["arm=cell.arm:main"] + []))'),
        ("setup.py", 'setup(entry_points={"console_scripts": "arm = cell.arm:main"})'),
        ("setup.cfg", "[options.entry_points]\nconsole_scripts =\n    arm = cell.arm:main\n"),
        ("pyproject.toml", '[project]\nname = "cell"\nscripts = {arm = "cell.arm:main"}\n'),
        ("pyproject.toml", '[project.entry-points.console_scripts]\narm = "cell.arm:main"\n'),
    ],
)
def test_console_scripts_are_read_without_building(file: str, text: str, tmp_path: Path) -> None:
    (tmp_path / file).write_text(text)
    assert SourcePackage("cell", tmp_path).scripts == {"arm": "cell.arm:main"}


def test_neighbours_in_a_workspace_are_found_and_what_colcon_leaves_out_is_not(tmp_path: Path) -> None:
    package = write_package(tmp_path)
    write_manifest(tmp_path / "src" / "stack" / "driver", "driver")
    write_manifest(tmp_path / "src" / "old" / "lost", "lost")
    (tmp_path / "src" / "old" / "COLCON_IGNORE").touch()
    write_manifest(tmp_path / "build" / "cell", "built")
    packages = packages_around(package / "launch" / "a.launch.py")
    assert {name: entry.folder.relative_to(tmp_path).as_posix() for name, entry in packages.items()} == {
        "cell": "src/cell",
        "driver": "src/stack/driver",
    }


def test_what_cmake_builds_is_refused_and_says_how_to_replace_it(tmp_path: Path) -> None:
    folder = write_manifest(tmp_path / "driver", "driver")
    (folder / "CMakeLists.txt").touch()
    executables = Executables(Launch("a.launch.py"), {"driver": SourcePackage("driver", folder)})
    with pytest.raises(LaunchError, match=r"driver/lidar is built by CMake.*\{\"driver/lidar\": replacement\}"):
        executables.of(command(["/lib/driver/lidar"]))
    with pytest.raises(LaunchError, match="gz sim is a command of the system"):
        executables.of(command(["gz", "sim"]))
