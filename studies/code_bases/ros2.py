"""Public packages of ROS 2 for the study of drafts: fetched at a commit, not a part of this project."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from studies.code_bases import CodeBase, ros2_declared

REPOSITORIES: Mapping[str, tuple[str, str]] = {
    "turtlebot3": ("https://github.com/ROBOTIS-GIT/turtlebot3", "da785b7201d317e6e2a662e41bb3d3fd50ebd503"),
    "demos": ("https://github.com/ros2/demos", "cbb174232b322eb3231d54af05765558c093ceca"),
    "example_interfaces": (
        "https://github.com/ros2/example_interfaces",
        "dec9e55175f95f0feecc46213df3a26c8543313f",
    ),
    "create3_examples": (
        "https://github.com/iRobotEducation/create3_examples",
        "94d88804d9ddd44e748a0af239034f9bf2a6f425",
    ),
    "irobot_create_msgs": (
        "https://github.com/iRobotEducation/irobot_create_msgs",
        "a4b94407977d5efb16e97fee52e031a7f1f39209",
    ),
}
"""Folder -> where it is cloned from, and the commit. Licences: Apache 2.0; of the last two BSD 3-Clause."""

_NODES = (
    ("obstacle-detection", "`turtlebot3_example`", "turtlebot3_example turtlebot3_obstacle_detection",
     ros2_declared.OBSTACLE_DETECTION),
    ("fibonacci", "`action_tutorials_py`", "action_tutorials_py fibonacci_action_server",
     ros2_declared.FIBONACCI_SERVER),
    ("dance", "`create3_examples_py`", "create3_examples_py create3_dance", ros2_declared.DANCE),
)  # fmt: skip
"""Key, name on the page, package and executable, what a testbench declares."""

KEYS = tuple(key for key, *_ in _NODES)


class FetchError(Exception):
    """A repository cannot be fetched, or is there at another commit."""


def nodes(folder: Path) -> Iterator[CodeBase]:
    """The nodes, in a folder in which their repositories are: those that are not there are cloned.

    Raises:
        FetchError: a repository cannot be cloned, or is there at another commit.
    """
    for name, (address, commit) in REPOSITORIES.items():
        fetch(folder / name, address, commit)
    nothing: frozenset[str] = frozenset()
    for key, name, asked, declared in _NODES:
        title = f"{name}, its node `{asked.split()[1]}` (ROS 2)"
        names = {"messages": frozenset(declared), "states": nothing, "transitions": nothing, "values": nothing}
        yield CodeBase(key, title, folder.resolve(), ("--ros2", asked), names)


def fetch(target: Path, address: str, commit: str, paths: Sequence[str] = ()) -> None:
    """Clone a repository, if it is not there, and check that it is at this commit.

    Args:
        target: folder of the clone.
        address: of the repository.
        commit: that is checked out.
        paths: folders and files in it, as patterns of `.gitignore`; without any, all.

    Raises:
        FetchError: it cannot be cloned, or is there at another commit.
    """
    if not target.exists():
        _git("clone", "--quiet", "--no-checkout", address, str(target))
        if paths:
            _git("-C", str(target), "sparse-checkout", "set", "--no-cone", *paths)
        _git("-C", str(target), "checkout", "--quiet", commit)
    is_at = _git("-C", str(target), "rev-parse", "HEAD")
    if is_at != commit:
        raise FetchError(f"{target}: expected commit {commit} of {address}, found {is_at}: remove the folder")


def _git(*arguments: str) -> str:
    ran = subprocess.run(["git", *arguments], capture_output=True, text=True, check=False)
    if ran.returncode:
        raise FetchError(f"git {' '.join(arguments)}: {ran.stderr.strip()}")
    return ran.stdout.strip()
