"""Code that is a program: a loop among the statements of a module runs the robot."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from pytest_hricdv.draft import Script
from pytest_hricdv.extra.draft.draft_analysis import CodeReader
from pytest_hricdv.extra.draft.project.draft import Draft
from pytest_hricdv.extra.draft.project.files import files

LOOP = "while True:\n{}    sleep(0.1)\n"
HELPER = "from time import sleep\n\n\ndef turn(degrees):\n    print(degrees)\n\n\n"
MAIN = "def main():\n    while True:\n        sleep(0.1)\n\n\n"
GUARD = 'if __name__ == "__main__":\n    '


@pytest.mark.parametrize(
    ("source", "entry"),
    [
        (HELPER + LOOP.format("    turn(9)\n"), "__main__"),
        (HELPER + "try:\n    while True:\n        sleep(1)\nexcept KeyboardInterrupt:\n    turn(0)\n", "__main__"),
        (HELPER + GUARD + "while True:\n        turn(9)\n        sleep(1)\n", "__main__"),
        (HELPER + MAIN + GUARD + "main()\n", "main"),
        (HELPER + "class Robot:\n    def run(self):\n        while True:\n            sleep(1)\n\n\n"
         + GUARD + "Robot().run()\n", "Robot"),
    ],
)  # fmt: skip
def test_a_program_is_the_entry_where_no_function_has_its_loop(source: str, entry: str, tmp_path: Path) -> None:
    (tmp_path / "cart.py").write_text(source, encoding="utf-8")
    model = CodeReader("cart.py", tmp_path).model()
    assert model.entry is not None
    assert model.entry.name == entry
    (text,) = [text for name, text in files(Draft(model, "cart", "person", tmp_path / "hri")) if name == "conftest.py"]
    assert ('Script("cart")' in text) == (entry == "__main__")


def test_each_run_executes_the_program_anew_under_its_own_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    source = f"count = 0\n{GUARD}count += 1\n    print(count, __import__('sys').modules['cart_a'].count)\n"
    (tmp_path / "cart_a.py").write_text(source, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    for _ in range(2):
        Script("cart_a")()
    assert capsys.readouterr().out == "1 1\n1 1\n"
    assert "cart_a" not in sys.modules
    with pytest.raises(ModuleNotFoundError, match="'no_such_cart'"):
        Script("no_such_cart")()


PROGRAM = """
import argparse
import time
from gopigo import us_dist, fwd, stop

SPEED = argparse.ArgumentParser().parse_args()

while True:
    distance_cm = us_dist(15)
    if distance_cm < 20:
        stop()
    else:
        fwd()
    time.sleep(0.2)
"""


@pytest.mark.slow
def test_the_tests_of_a_program_reach_its_branches(tmp_path: Path) -> None:
    (tmp_path / "avoider.py").write_text(PROGRAM, encoding="utf-8")
    draft = [sys.executable, "-m", "pytest_hricdv", "init", "hri", "--from", "avoider.py", "--budget", "16"]
    made = subprocess.run(draft, cwd=tmp_path, capture_output=True, text=True, timeout=500, check=True)
    assert "hollow" not in made.stdout
    tests = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"]
    ran = subprocess.run(tests, cwd=tmp_path / "hri", capture_output=True, text=True, timeout=500, check=False)
    assert (ran.returncode, "avoider.py" in ran.stdout) == (0, False), ran.stdout  # every line and branch is covered
