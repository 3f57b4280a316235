"""What importing the code under test covers, and that nothing is imported for the sake of a figure."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.plugin.project import A_WORKER, change, report

pytestmark = pytest.mark.slow  # each test is a session or several

SUITE = ("--hri-suite=by-hand", "-p", "no:cacheprovider")
ALONE = (*SUITE, "-p", "no:xdist")
CALIBRATE = """
from pathlib import Path

Path(__file__).with_name("moved").write_text("the arm has moved")
SPEED = 1 if SUITE else 2
"""
in_both_modes = pytest.mark.parametrize("options", [("-p", "no:xdist"), A_WORKER], ids=["plain", "on a worker"])


def add(lamps: pytest.Pytester, name: str, text: str) -> None:
    """Write a module of the code under test."""
    (lamps.path / "lamps" / name).write_text(text, encoding="utf-8")


def files(folder: Path) -> dict[str, tuple[int, int]]:
    """File -> covered statements, and all of them."""
    written = report(folder)["code_under_test"]["files"]
    return {file["file"].removeprefix("lamps/"): (file["covered"], file["statements"]) for file in written}


def never_imported(folder: Path) -> list[str]:
    """The files that the report lists as never imported."""
    listed: list[str] = report(folder)["code_under_test"].get("never_imported", [])
    return listed


def by_test(folder: Path) -> dict[str, Any]:
    """Name of a test -> what it covered of the code."""
    return {test["id"]: test["code"] for test in report(folder)["tests"]}


@in_both_modes
def test_what_nothing_imports_is_never_run_and_is_listed_as_never_imported(
    lamps: pytest.Pytester, options: tuple[str, ...]
) -> None:
    add(lamps, "calibrate.py", CALIBRATE)
    add(lamps, "quits.py", "import sys\nsys.exit(3)\n")
    add(lamps, "hardware.py", "import RPi.GPIO\n")
    result = lamps.runpytest_subprocess("-v", *SUITE, *options)
    assert result.ret == 0
    assert not (lamps.path / "lamps" / "moved").exists()
    covered = files(lamps.path)
    assert (covered["calibrate.py"], covered["quits.py"], covered["hardware.py"]) == ((0, 3), (0, 2), (0, 1))
    assert covered["guide.py"][0] > 20
    listed = ["lamps/calibrate.py", "lamps/hardware.py", "lamps/quits.py"]
    assert never_imported(lamps.path) == listed
    result.stdout.fnmatch_lines(["  never imported        lamps/calibrate.py, lamps/hardware.py, *"])
    page = (lamps.path / "hri-report" / "index.html").read_text(encoding="utf-8")
    assert page.count("never imported") >= len(listed)
    gaps = [gap for gap in report(lamps.path)["closure"]["gaps"] if gap["location"] == "lamps/calibrate.py"]
    assert [gap["reason"] for gap in gaps] == ["never imported: no test imports this file"]


@pytest.mark.parametrize(
    "imported",
    [
        "    import importlib\n    return importlib.import_module('lamps.dimmer').LEVEL",
        "    import importlib\n    return importlib.import_module('.dimmer', 'lamps').LEVEL",
        "    return __import__('lamps.dimmer').dimmer.LEVEL",
        "    import lamps.dimmer as dimmer\n    return dimmer.LEVEL",
        "    from . import dimmer\n    return dimmer.LEVEL",
        "    from .dimmer import LEVEL\n    return LEVEL",
    ],
)
def test_however_a_module_is_imported_it_counts_where_it_is(lamps: pytest.Pytester, imported: str) -> None:
    add(lamps, "dimmer.py", "LEVEL = 10.0\n")
    change(lamps.path, "lamps/guide.py", "    return 10.0", imported)
    lamps.runpytest_inprocess(*ALONE)
    assert files(lamps.path)["dimmer.py"] == (1, 1)
    together = by_test(lamps.path)
    for name in together:
        lamps.runpytest_inprocess(*ALONE, "-k", name)
        assert by_test(lamps.path)[name] == together[name]


@pytest.mark.parametrize(
    ("text", "raised"),
    [
        ("import RPi.GPIO\n", "lamps/hardware.py:2: <module>: ModuleNotFoundError: No module named 'RPi'"),
        ("import sys\nsys.exit('no relay')\n", "lamps/hardware.py:3: <module>: SystemExit: no relay"),
    ],
)
@in_both_modes
def test_a_module_that_the_testbench_needs_and_that_cannot_be_imported_is_one_located_error(
    lamps: pytest.Pytester, text: str, raised: str, options: tuple[str, ...]
) -> None:
    add(lamps, "hardware.py", f'"""Relays."""\n{text}')
    change(lamps.path, "conftest.py", "    from lamps import guide\n", "    from lamps import guide, hardware\n")
    result = lamps.runpytest_subprocess(*SUITE, *options)
    result.assert_outcomes(failed=1)
    told = result.stdout.str()
    assert raised in told
    assert "The testbench's run needs lamps.hardware, which cannot be imported: install" in told
    assert "Traceback" not in told
    assert report(lamps.path)["not_run"] == 3


def test_what_was_imported_before_it_could_be_followed_is_imported_again_once_and_before_the_first_test(
    lamps: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("PYTEST_CURRENT_TEST")  # of this test
    site = lamps.path / "site-packages"
    site.mkdir()
    log = lamps.path / "imports"
    text = (
        "import os, sys\n"
        f"with open({str(log)!r}, 'a') as file:\n"
        "    file.write(os.environ.get('PYTEST_CURRENT_TEST', 'before') + '\\n')\n"
        f"if len(open({str(log)!r}).readlines()) > 1:\n"
        "    sys.exit('the relay is in use')\n"
    )
    (site / "relays.py").write_text(text, encoding="utf-8")
    change(lamps.path, "pytest.ini", "pythonpath = .", "pythonpath = . site-packages")
    change(lamps.path, "conftest.py", 'code=("lamps",)', 'code=("lamps", "relays")')
    conftest = (lamps.path / "conftest.py").read_text(encoding="utf-8")
    (lamps.path / "conftest.py").write_text(f"import relays\n{conftest}", encoding="utf-8")
    result = lamps.runpytest_subprocess(*ALONE)
    assert result.ret == 0
    assert log.read_text().splitlines() == ["before", "before"]
    why = "imported again to be measured, it raised SystemExit: the relay is in use"
    assert report(lamps.path)["code_under_test"]["unmeasured_files"] == {"relays.py": why}
    assert files(lamps.path)["guide.py"][0] > 20


def test_code_in_a_folder_of_pythonpath_is_followed_from_its_first_import(
    lamps: pytest.Pytester, tmp_path: Path
) -> None:
    """A draft beside its code: what it puts in the place of missing modules is there in this process only."""
    (tmp_path / "relays.py").write_text("import board\n\nPIN = board.D4\n", encoding="utf-8")
    change(lamps.path, "pytest.ini", "pythonpath = .", f"pythonpath = . {tmp_path}")
    change(lamps.path, "conftest.py", 'code=("lamps",)', 'code=("lamps", "relays")')
    conftest = (lamps.path / "conftest.py").read_text(encoding="utf-8")
    stand_in = "import sys, types\nsys.modules['board'] = types.SimpleNamespace(D4=4)\nimport relays\n"
    (lamps.path / "conftest.py").write_text(f"{stand_in}{conftest}", encoding="utf-8")
    assert lamps.runpytest_subprocess(*ALONE).ret == 0
    assert "unmeasured_files" not in report(lamps.path)["code_under_test"]
    assert [covered for name, covered in files(lamps.path).items() if name.endswith("relays.py")] == [(2, 2)]
