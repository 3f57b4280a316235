"""Which files are collected: with a suite and no paths, those of `hri_testpaths` only."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.plugin.project import change, in_each_mode, nodeids

HOSTS = "hosts/test_lamps.py::test_lamps"
COLLECT = ("--collect-only", "-q", "--hri-suite=by-hand")


@pytest.fixture
def hosts(lamps: pytest.Pytester) -> Path:
    """A project with its host test in a folder, and other tests that cannot be imported."""
    folder = lamps.path / "hosts"
    folder.mkdir()
    (lamps.path / "test_lamps.py").rename(folder / "test_lamps.py")
    (lamps.path / "others").mkdir()
    for name in ("conftest.py", "test_others.py"):
        (lamps.path / "others" / name).write_text("import a_package_that_is_not_installed\n", encoding="utf-8")
    ini(lamps, "hri_testpaths = hosts")
    return folder


def ini(lamps: pytest.Pytester, line: str) -> None:
    """Add a line to the ini file."""
    change(lamps.path, "pytest.ini", "pythonpath = .\n", f"pythonpath = .\n{line}\n")


@pytest.mark.slow
@in_each_mode
@pytest.mark.usefixtures("hosts")
def test_files_elsewhere_are_not_imported(lamps: pytest.Pytester, options: tuple[str, ...]) -> None:
    result = lamps.runpytest_inprocess("--hri-suite=by-hand", *options)
    result.assert_outcomes(passed=3, xfailed=1)
    assert result.ret == 0


def test_other_tests_in_the_same_files_are_deselected(lamps: pytest.Pytester, hosts: Path) -> None:
    (hosts / "test_more.py").write_text("def test_more():\n    pass\n", encoding="utf-8")
    listed = nodeids(lamps.runpytest_inprocess(*COLLECT))
    assert [line.startswith(HOSTS) for line in listed] == [True] * 4


def test_the_same_tests_are_collected_from_every_folder(
    lamps: pytest.Pytester, hosts: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    at_root = nodeids(lamps.runpytest_inprocess(*COLLECT))
    monkeypatch.chdir(hosts)
    in_folder = nodeids(lamps.runpytest_inprocess(*COLLECT))
    monkeypatch.chdir(lamps.path / "models")
    elsewhere = nodeids(lamps.runpytest_inprocess(*COLLECT))
    assert len(at_root) == 4
    assert in_folder == elsewhere == at_root


@pytest.mark.parametrize("value", ["hosts/test_l*.py", "host?", "**/test_lamps.py", "hosts/test_lamps.py hosts"])
@pytest.mark.usefixtures("hosts")
def test_the_key_has_globs_and_several_paths(lamps: pytest.Pytester, value: str) -> None:
    listed = nodeids(lamps.runpytest_inprocess(*COLLECT, "-o", f"hri_testpaths={value}"))
    assert len(listed) == len(set(listed)) == 4


def test_a_path_that_does_not_exist_is_an_error_with_its_place(lamps: pytest.Pytester) -> None:
    ini(lamps, "hri_testpaths = . hosts/*.txt")
    result = lamps.runpytest_inprocess("--hri-suite=by-hand")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    folder = lamps.path
    result.stderr.fnmatch_lines(
        [f"ERROR: {folder}/pytest.ini: hri_testpaths: no such file or folder: {folder}/hosts/*.txt"]
    )


@pytest.mark.parametrize("arguments", [("--hri-suite=by-hand", "."), ("-o", "hri_suite=by-hand"), ()])
@pytest.mark.usefixtures("hosts")
def test_with_paths_or_without_a_named_suite_all_files_are_collected(
    lamps: pytest.Pytester, arguments: tuple[str, ...]
) -> None:
    result = lamps.runpytest_inprocess(*arguments)
    assert result.ret != 0
    result.stdout.fnmatch_lines(["*No module named 'a_package_that_is_not_installed'*"])


def test_without_the_key_testpaths_are_collected_and_other_tests_deselected(lamps: pytest.Pytester) -> None:
    (lamps.path / "deep").mkdir()
    (lamps.path / "deep" / "test_deep.py").write_text("from test_lamps import test_lamps\n", encoding="utf-8")
    result = lamps.runpytest_inprocess(*COLLECT)
    assert len(nodeids(result)) == 8
    ini(lamps, "testpaths = deep")
    listed = nodeids(lamps.runpytest_inprocess(*COLLECT))
    assert [line.startswith("deep/") for line in listed] == [True] * 4
