"""The code under test knows neither who tests it nor what it runs in; and it is as large as that of the case study."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from pytest_hricdv.coverage.code_map import map_code

ROOT = Path(__file__).parents[2]

BLOCKED = """
import importlib, pkgutil, sys

class Blocker:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("pytest_hricdv", "sim", "pytest", "pybullet", "greenlet"):
            raise ImportError(f"the controller asks for {name}")

sys.meta_path.insert(0, Blocker())
import controller
for module in pkgutil.walk_packages(controller.__path__, "controller."):
    print(importlib.import_module(module.name).__name__)
"""


def test_the_controller_imports_neither_the_plugin_nor_the_world() -> None:
    done = subprocess.run(
        [sys.executable, "-c", BLOCKED], cwd=ROOT, capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "controller.machine" in done.stdout.split()


def test_the_controller_has_the_size_of_the_original() -> None:
    code = map_code(("controller",), ROOT)
    assert 250 <= code.statements <= 330
