"""The command `hricdv`: one table, consistent help, and names that are nearly right."""

from __future__ import annotations

import subprocess
import sys

import pytest

from pytest_hricdv.__main__ import GROUPS, main


@pytest.mark.parametrize(
    ("given", "near"),
    [
        (("inti",), "init"),
        (("updat",), "update"),
        (("init", "--form=x"), "--from"),
        (("report", "merg", "x"), "merge"),
        (("report", "gate", "x", "--fail-undr=3"), "--fail-under"),
        (("model", "trase", "x"), "trace"),
        (("campaign", "stauts"), "status"),
    ],
)
def test_a_misspelt_name_suggests_the_right_one(
    given: tuple[str, ...], near: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(given)
    assert ended.value.code == 2
    assert capsys.readouterr().err.endswith(f"; did you mean {near}?\n")


def test_a_name_like_no_other_suggests_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["xyzzy"])
    assert "did you mean" not in capsys.readouterr().err


@pytest.mark.parametrize("command", ["", "init", "update", "suggest", "record", *GROUPS])
def test_each_command_has_a_help_with_its_own_name(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main([*filter(None, [command]), "--help"])
    said = capsys.readouterr().out
    assert ended.value.code == 0
    assert said.startswith(f"usage: hricdv {command}".rstrip())
    assert "python -m" not in said.replace("`python -m pytest_hricdv`", "")


def test_without_a_command_it_lists_all_and_imports_none_of_the_groups() -> None:
    code = (
        "import sys; from pytest_hricdv.__main__ import GROUPS, main; status = main([]); "
        "sys.exit(status or sum(group.module in sys.modules for group in GROUPS.values()))"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert all(f"    {name} " in ran.stdout for name in ("init", "update", *GROUPS))
