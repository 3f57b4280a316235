from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import pytest

from pytest_hricdv.extra.ros2 import interface_packages

HERE = Path(__file__).parent


@pytest.fixture
def interfaces(tmp_path: Path) -> Iterator[Callable[[Mapping[str, str]], None]]:
    """Lets packages be imported of which there are interface files, by their paths; those of `interface_files`, too."""
    pytest.importorskip("rosidl_adapter", reason="needs rosidl_adapter, of a ROS 2 distribution or from pip")
    before = dict(interface_packages._FINDER.folders)
    imported = set(sys.modules)

    def provide(files: Mapping[str, str]) -> None:
        for path, text in files.items():
            (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / path).write_text(text, encoding="utf-8")
        packages = sorted({path.partition("/")[0] for path in files})
        standard = [folder for folder in sorted((HERE / "interface_files").iterdir()) if folder.is_dir()]
        interface_packages.provide_interfaces([*standard, *(tmp_path / package for package in packages)])

    yield provide
    packages = set(interface_packages._FINDER.folders)
    interface_packages._FINDER.folders = before
    for name in set(sys.modules) - imported:
        if name.partition(".")[0] in packages:
            del sys.modules[name]


@pytest.fixture
def ros_messages(interfaces: Callable[[Mapping[str, str]], None]) -> None:
    """Messages of ROS and of packages of others, where they are not installed: made of their interface files."""
    interfaces({})


@pytest.fixture
def cell_msgs(interfaces: Callable[[Mapping[str, str]], None]) -> None:
    """Messages of a cell."""
    interfaces(
        {
            "cell_msgs/msg/Point.msg": "float64 x\nfloat64 y\n",
            "cell_msgs/msg/Scan.msg": "string frame\nbool near\nint32 count\nPoint origin\nfloat64[] ranges\n"
            "string[] labels\n",
            "cell_msgs/msg/Other.msg": "string frame\n",
            "cell_msgs/srv/Grasp.srv": "float64 force\n---\nbool held\n",
            "cell_msgs/action/Fetch.action": "string part\n---\nbool found\n---\nfloat64 way\n",
        }
    )
