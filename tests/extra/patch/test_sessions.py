"""What changed since a revision, and which of it the tests execute."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from pytest_hricdv.extra.patch.feature import PatchError, Repository
from tests import json_schema
from tests.plugin.project import change, command, report

SUITE = "--hri-suite=by-hand"


def git(folder: Path, *arguments: str) -> str:
    """What git prints."""
    identity = ("-c", "user.name=tests", "-c", "user.email=tests@localhost", "-c", "init.defaultBranch=main")
    done = subprocess.run(["git", "-C", folder, *identity, *arguments], check=True, capture_output=True, text=True)
    return done.stdout.strip()


@pytest.fixture
def committed(lamps: pytest.Pytester) -> pytest.Pytester:
    """The lamps project, committed as `main`, then on a branch of its own."""
    (lamps.path / ".gitignore").write_text("hri-report\n__pycache__\n")
    git(lamps.path, "init")
    git(lamps.path, "add", "--all")
    git(lamps.path, "commit", "--message=one")
    git(lamps.path, "switch", "--create=mine")
    return lamps


def test_a_patch_has_its_statements_what_is_missing_and_a_threshold(committed: pytest.Pytester) -> None:
    change(
        committed.path,
        "lamps/guide.py",
        "def level_for(wish):\n",
        "def level_for(wish):\n    wish = (\n        wish\n    )\n",
    )
    change(committed.path, "lamps/guide.py", "def serviced():\n", "def serviced():\n    print()\n")
    (committed.path / "lamps" / "added.py").write_text("# nothing but one statement\nADDED = 1\n")
    result = committed.runpytest_inprocess(SUITE, "--hri-patch=main", "--hri-fail-under=patch=50")
    result.stdout.fnmatch_lines(
        [
            "patch         4 tests execute 1 of 3 statements that changed since main (33.3 %)*",
            "  lamps/added.py  2",
            "  lamps/guide.py  *",
            "FAILED suite by-hand: patch 33.33 %, at least 50 % asked for",
        ]
    )
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    saved = report(committed.path)
    json_schema.REPORT.validate(saved)
    assert saved["patch"]["base"] == git(committed.path, "rev-parse", "main")
    assert [(file["file"], len(file["statements"])) for file in saved["patch"]["files"]] == [
        ("lamps/added.py", 1),
        ("lamps/guide.py", 2),
    ]
    page = (committed.path / "hri-report" / "index.html").read_text(encoding="utf-8")
    assert "4 tests execute 1 of 3 statements that changed since main" in page


def test_a_branch_is_compared_with_where_it_began(committed: pytest.Pytester) -> None:
    git(committed.path, "switch", "main")
    change(committed.path, "lamps/guide.py", "def level_for(wish):\n", "def level_for(wish):\n    print()\n")
    git(committed.path, "commit", "--all", "--message=another's")
    git(committed.path, "switch", "mine")
    result = committed.runpytest_inprocess(SUITE, "--hri-patch=main")
    result.stdout.fnmatch_lines(["patch         no statement of the code under test changed since main"])


def test_shards_together_have_the_patch_of_the_whole_suite(committed: pytest.Pytester) -> None:
    change(committed.path, "lamps/guide.py", "def level_for(wish):\n", "def level_for(wish):\n    print()\n")
    for number in (1, 2):
        committed.runpytest_inprocess(
            SUITE, "--hri-patch=main", f"--hri-shard={number}/2", f"--hri-report=part-{number}"
        )
    done = command(
        "merge", *(str(committed.path / f"part-{number}") for number in (1, 2)), "-o", str(committed.path / "all")
    )
    assert "1 of 1 statement that changed since main (100.0 %)" in done.stdout


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--hri-patch=nowhere",), "--hri-patch: there is no revision nowhere in *"),
        (("--hri-patch=--output=made",), "--hri-patch: there is no revision --output=made in *"),
        (("--hri-patch=main", "--hri-no-cov"), "--hri-patch and --hri-no-cov: *"),
        (("--hri-fail-under=patch=50",), "--hri-fail-under=patch=50: add --hri-patch=REV, which says what changed"),
    ],
)
def test_what_cannot_be_compared_is_refused_before_any_test_runs(
    committed: pytest.Pytester, options: tuple[str, ...], told: str
) -> None:
    result = committed.runpytest_inprocess(SUITE, *options)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines([f"*{told}"])
    assert not (committed.path / "made").exists()


def test_code_that_git_ignores_is_not_taken_for_new(committed: pytest.Pytester) -> None:
    (committed.path / ".gitignore").write_text("lamps/made.py\n")
    (committed.path / "lamps" / "made.py").write_text("MADE = 1\n")
    repository = Repository(committed.path)
    with pytest.raises(PatchError, match=r"git ignores .*made\.py"):
        repository.find_changed_lines(repository.find_base("main"), committed.path / "lamps" / "made.py")


@pytest.mark.parametrize("name", ["a b.py", "größe.py", "-n.py", "tab\there.py", "qu'ote\".py"])
def test_any_name_of_a_file_is_compared(committed: pytest.Pytester, name: str) -> None:
    path = committed.path / name
    path.write_text("one = 1\ntwo = 2\n", encoding="utf-8")
    git(committed.path, "add", "--all")
    git(committed.path, "commit", "--message=odd name")
    path.write_text("one = 1\nthree = 3\ntwo = 2\n", encoding="utf-8")
    repository = Repository(committed.path)
    assert repository.find_changed_lines(repository.find_base("HEAD"), path) == frozenset({2})
    path.write_text("two = 2\n", encoding="utf-8")
    assert repository.find_changed_lines(repository.find_base("HEAD"), path) == frozenset()
