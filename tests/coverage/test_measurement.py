"""Measuring inside a greenlet: alone, beside a user's own measurement, and not at all. Each in a process of its own."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from pytest_hricdv.coverage.import_process import import_again
from tests.coverage.project import write_package

SCRIPT = """
import json, sys
from pathlib import Path
from greenlet import greenlet
from pytest_hricdv.coverage.measurement import choose
from pytest_hricdv.coverage.code_map import map_code

{before}
import graded
graded.grade(1)
code = map_code(["graded"], Path.cwd())
measurement = choose(code, contexts_by_test=False)

def use(number):
    def body():
        import graded
        graded.grade(number)
        pause.switch()
    return body

pause = greenlet.getcurrent()
missing = dict()
nodes = [(str(number), greenlet(measurement.measure(f"hricdv|{{number}}", use(number)))) for number in (5, 0)]
for name, node in nodes:
    node.switch()          # runs to the pause; other code runs before it ends
    {between}
    node.switch()
    bits = measurement.take("hricdv|" + name)
    missing[name] = None if bits is None else [list(lines) for _, lines, _ in code.list_misses(bits)][0]
{after}
print(json.dumps([measurement.reason, missing]))
"""


def execute(folder: Path, script: str) -> Any:
    """What a script prints last, as JSON."""
    (folder / "script.py").write_text(script, encoding="utf-8")
    process = subprocess.run([sys.executable, "script.py"], cwd=folder, capture_output=True, text=True, timeout=60)
    assert process.returncode == 0, process.stderr
    return json.loads(process.stdout.splitlines()[-1])


def run(folder: Path, before: str = "", between: str = "", after: str = "") -> tuple[str, dict[str, list[int] | None]]:
    write_package(folder, "graded")
    reason, missing = execute(folder, SCRIPT.format(before=before, between=between, after=after))
    return reason, missing


MISSING = {"5": [9, 10, 11, 15], "0": [8, 11, 15]}
JOIN = 'import coverage; user = coverage.Coverage(data_file=None, include=["*/graded/*"], branch=True); user.start()'


@pytest.mark.parametrize("meanwhile", ["", "graded.grade(1)", "assert sys.gettrace() is None"])
def test_each_test_gets_its_own_lines_and_those_of_importing_and_no_other_greenlet_is_traced(
    tmp_path: Path, meanwhile: str
) -> None:
    assert run(tmp_path, between=meanwhile) == ("", MISSING)


def test_greenlets_that_the_code_makes_itself_are_measured_with_it(tmp_path: Path) -> None:
    script = SCRIPT.replace(
        "        graded.grade(number)\n",
        "        greenlet(lambda: greenlet(graded.grade).switch(number)).switch()\n",
    )
    write_package(tmp_path, "graded")
    assert execute(tmp_path, script.format(before="", between="", after="")) == ["", MISSING]


def test_a_running_measurement_is_joined_and_goes_on(tmp_path: Path) -> None:
    # The user's own figures must be complete: line 11 ran outside of our greenlets, line 15 after them.
    after = "graded.never(); user.stop(); f = str(code.files[0].path)\n"
    after += "assert set(user.get_data().lines(f)) >= {8, 10, 11, 15}"
    assert run(tmp_path, before=JOIN, between="assert sys.gettrace() is not None", after=after) == ("", MISSING)


def test_a_measurement_of_something_else_is_reported_as_unmeasured(tmp_path: Path) -> None:
    before = JOIN.replace("*/graded/*", "*/elsewhere/*")
    reason, missing = run(tmp_path, before=before)
    assert "does not measure the code under test" in reason
    assert missing == {"5": None, "0": None}


def test_a_debugger_is_left_alone(tmp_path: Path) -> None:
    reason, missing = run(tmp_path, before="sys.settrace(lambda *_: None)")
    assert "debugger" in reason
    assert missing == {"5": None, "0": None}


BROKEN = {
    "raises": ("raise RuntimeError('broken on import')\n", "raised RuntimeError: broken on import"),
    "exits": ("import sys\nprint('}')\nsys.exit('no hardware')\n", "raised SystemExit: no hardware"),
    "ends": ("import os\nos._exit(3)\n", "was imported in a process that ended with status 3"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_module_that_cannot_be_imported_again_has_its_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    source, reason = BROKEN[name]
    file = write_package(tmp_path, f"broken_{name}", source)
    monkeypatch.syspath_prepend(tmp_path)
    answer = import_again([f"broken_{name}"], [str(file)])
    assert answer.problems == {f"broken_{name}": reason}
