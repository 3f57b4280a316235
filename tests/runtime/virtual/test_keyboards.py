"""Libraries that read the keyboard of the machine are refused, where a node uses them."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

from pytest_hricdv.runtime import Kernel
from pytest_hricdv.runtime.node_error import NodeError
from pytest_hricdv.runtime.virtual import VirtualModules
from pytest_hricdv.runtime.virtual.outside import guard_run

PYNPUT = """
class Key:
    space = 'space'

class Listener:
    def __init__(self, on_press=None):
        self.on_press = on_press
"""
KEYBOARD = "def is_pressed(key):\n    return False\n"

CURSES = "import curses\nUP = curses.KEY_UP\ndef main():\n    curses.wrapper(print)\n"
INITSCR = "from curses import initscr, error\ndef main():\n    initscr()\n"
LISTENER = (
    "from pynput import keyboard\nSPACE = keyboard.Key.space\ndef main():\n    keyboard.Listener(on_press=print)\n"
)
PRESSED = "import keyboard\ndef main():\n    keyboard.is_pressed('w')\n"
INSIDE = "def main():\n    import keyboard\n    keyboard.is_pressed('w')\n"


@pytest.fixture
def packages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Installed packages that stand for those of the package index; and a folder of code under test."""
    installed = tmp_path / "site-packages"
    (installed / "pynput").mkdir(parents=True)
    (installed / "pynput" / "__init__.py").touch()
    (installed / "pynput" / "keyboard.py").write_text(PYNPUT)
    (installed / "keyboard.py").write_text(KEYBOARD)
    for folder in (installed, tmp_path):
        monkeypatch.syspath_prepend(folder)
    yield tmp_path
    for name in ("pynput", "pynput.keyboard", "keyboard", "key_node"):
        sys.modules.pop(name, None)


def run(folder: Path, source: str, *, is_imported_before: bool) -> ModuleType:
    (folder / "key_node.py").write_text(source)
    kernel = Kernel()
    if is_imported_before:
        __import__("key_node")
    with VirtualModules(["key_node"]).install(), guard_run(kernel):
        module = __import__("key_node")
        kernel.spawn("teleop", module.main)
        try:
            kernel.run(10.0)
        finally:
            kernel.close()
    return module


@pytest.mark.parametrize("is_imported_before", [False, True])
@pytest.mark.parametrize(
    ("source", "line", "name"),
    [
        (CURSES, 4, "curses.wrapper"),
        (INITSCR, 3, "curses.initscr"),
        (LISTENER, 4, "pynput.keyboard.Listener"),
        (PRESSED, 3, "keyboard.is_pressed"),
        (INSIDE, 3, "keyboard.is_pressed"),
    ],
)
def test_it_is_refused_with_its_line(
    packages: Path, source: str, line: int, name: str, is_imported_before: bool
) -> None:
    with pytest.raises(NodeError, match=rf"key_node.py:{line}: node teleop uses {name}, which reads the keyboard"):
        run(packages, source, is_imported_before=is_imported_before)


def test_a_projects_own_module_of_that_name_is_left_alone(packages: Path) -> None:
    (packages / "keyboard.py").write_text(KEYBOARD)
    run(packages, PRESSED, is_imported_before=False)


def test_outside_of_nodes_they_are_the_real_ones(packages: Path) -> None:
    (packages / "key_node.py").write_text(LISTENER)
    with VirtualModules(["key_node"]).install():
        module = __import__("key_node")
        module.main()
        assert module.SPACE == "space"
