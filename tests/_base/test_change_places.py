"""Where code changes names of other modules."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType

import pytest

from pytest_hricdv._base.self_check import places_of_change

CHANGES = (
    "json.dumps = None",
    "del json.dumps",
    "vars(json)['dumps'] = None",
    "setattr(json, 'dumps', None)",
    "json.dumps.insert(0, None)",
)


@pytest.mark.parametrize("change", CHANGES)
def test_the_line_of_a_change_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, change: str) -> None:
    module = ModuleType("arm.grip")
    module.__file__ = str(tmp_path / "grip.py")
    monkeypatch.setitem(sys.modules, "arm.grip", module)
    (tmp_path / "grip.py").write_text(f"import json\nprint(json.dumps(1))\n{change}\n")
    assert places_of_change(["json.dumps"], ["arm"]) == (f"{module.__file__}:3",)
    assert places_of_change(["json.dumps"], ["leg"]) == ()
    (tmp_path / "grip.py").write_text("no python")
    assert places_of_change(["json.dumps"], ["arm"]) == ()


def test_the_line_that_replaces_a_module_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    module = ModuleType("arm_lock")
    module.__file__ = str(tmp_path / "arm_lock.py")
    monkeypatch.setitem(sys.modules, "arm_lock", module)
    (tmp_path / "arm_lock.py").write_text("import sys\n\nsys.modules['json.decoder'] = None\n")
    assert places_of_change(["sys.modules['json.decoder']"], ["arm_lock"]) == (f"{module.__file__}:3",)


@pytest.mark.parametrize(
    "change", ["for name in N:\n    sys.modules[name] = None", "sys.modules.update(N)", "setattr(sys.modules, N[0], 1)"]
)
def test_the_line_that_changes_a_computed_name_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, change: str
) -> None:
    module = ModuleType("arm_lock")
    module.__file__ = str(tmp_path / "arm_lock.py")
    monkeypatch.setitem(sys.modules, "arm_lock", module)
    (tmp_path / "arm_lock.py").write_text(f"N = ['csv']\nOTHER[N[0]] = None\n{change}\n")
    line = 2 + len(change.splitlines())
    assert places_of_change(["sys.modules['csv']"], ["arm_lock"]) == (f"{module.__file__}:{line}",)
