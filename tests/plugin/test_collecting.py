"""Collecting: what `--collect-only` lists, and where the tests come from."""

from __future__ import annotations

import re

import pytest

from tests.plugin.project import MODES, change, nodeids

ID = re.compile(r"test_lamps\.py::test_lamps\[rl-(hall|cellar)(-polite)?(-curt)?-[0-9a-f]{8}\]")
COLLECT = ("--collect-only", "-q", "--hri-suite=rl")


def test_ids_are_the_same_in_every_mode(lamps: pytest.Pytester) -> None:
    first, *others = [lamps.runpytest_subprocess(*COLLECT, *options) for options in MODES.values()]
    listed = nodeids(first)
    assert first.ret == 0
    assert len(listed) == len(set(listed)) > 20
    assert all(ID.fullmatch(line) for line in listed)
    assert [nodeids(other) for other in others] == [listed, listed]


def test_the_second_collection_comes_from_the_cache(lamps: pytest.Pytester) -> None:
    learning = "hricdv: generating suite rl (seed 0) ..."
    lamps.runpytest_inprocess("--collect-only", "--hri-suite=rl").stdout.fnmatch_lines([learning])
    lamps.runpytest_inprocess("--collect-only", "--hri-suite=rl").stdout.no_fnmatch_line(learning)
    uncached = lamps.runpytest_inprocess("--collect-only", "--hri-suite=rl", "-p", "no:cacheprovider")
    uncached.stdout.fnmatch_lines([learning])


def test_listing_writes_no_report_and_prints_no_section(lamps: pytest.Pytester) -> None:
    result = lamps.runpytest_inprocess("--collect-only", "--hri-suite=rl", "--hri-fail-under=statements=100")
    assert result.ret == 0
    result.stdout.fnmatch_lines(["hri: lamps, suite rl, seed 0, 34 tests"])
    result.stdout.no_fnmatch_line("*= human-robot interaction =*")
    assert not (lamps.path / "hri-report").exists()


def test_another_seed_gives_other_tests(lamps: pytest.Pytester) -> None:
    listed = [nodeids(lamps.runpytest_inprocess(*COLLECT, f"--hri-seed={seed}")) for seed in (0, 1)]
    assert set(listed[0]).isdisjoint(listed[1])


def test_a_changed_model_is_explored_again(lamps: pytest.Pytester) -> None:
    before = nodeids(lamps.runpytest_inprocess(*COLLECT))
    change(lamps.path, "models/visitor.asl", "greet; set_lamp(level, 10)", "greet; greet; set_lamp(level, 10)")
    assert set(before) != set(nodeids(lamps.runpytest_inprocess(*COLLECT)))


def test_number_of_tests_and_of_concretizations(lamps: pytest.Pytester) -> None:
    few = nodeids(lamps.runpytest_inprocess(*COLLECT, "--hri-tests=3"))
    doubled = nodeids(lamps.runpytest_inprocess(*COLLECT, "--hri-tests=3", "--hri-concretizations=2"))
    assert len(few) == 3
    assert len(doubled) == 6
    assert doubled[::2] == few
    assert doubled[1::2] == [nodeid.replace("]", "-k1]") for nodeid in few]


@pytest.mark.parametrize(
    ("selection", "suites"),
    [
        ("by-hand,rl", {"by-hand", "rl"}),
        ("all", {"by-hand", "bdi-random", "rl", "pseudorandom"}),
        ("rl,rl", {"rl"}),
    ],
)
def test_several_suites(lamps: pytest.Pytester, selection: str, suites: set[str]) -> None:
    listed = nodeids(lamps.runpytest_inprocess("--collect-only", "-q", f"--hri-suite={selection}", "--hri-tests=4"))
    assert len(listed) == len(set(listed)) == 4 * len(suites)
    assert {suite for suite in suites for line in listed if f"[{suite}-" in line} == suites


def test_an_exported_suite_reads_back_with_its_ids(lamps: pytest.Pytester) -> None:
    exported = lamps.runpytest_inprocess(*COLLECT, "--hri-export=kept")
    read = lamps.runpytest_inprocess("--collect-only", "-q", "--hri-suite=kept")
    assert read.ret == 0
    assert nodeids(read) == nodeids(exported)
    assert [path.name for path in (lamps.path / "kept").iterdir()] == ["rl.txt"]


def test_a_file_of_bare_commands_is_a_suite(lamps: pytest.Pytester) -> None:
    (lamps.path / "recorded.txt").write_text("enter hall\nset_lamp level=10\n\ngreet  # and nothing else\n")
    listed = nodeids(lamps.runpytest_inprocess("--collect-only", "-q", "--hri-suite=recorded.txt"))
    assert len(listed) == 2
    assert all("[recorded-" in nodeid for nodeid in listed)


BROKEN = "raise ImportError('whoever imports this file fails')\n"


@pytest.mark.parametrize("options", MODES.values(), ids=MODES.keys())
def test_files_without_generated_tests_are_not_even_imported(lamps: pytest.Pytester, options: tuple[str, ...]) -> None:
    (lamps.path / "test_others.py").write_text(BROKEN, encoding="utf-8")
    (lamps.path / "test_classes.py").write_text(f"class Mine(dict):\n    pass\n\n\n{BROKEN}", encoding="utf-8")
    (lamps.path / "test_texts.py").write_text(f"TEXT = 'def test_it(hri_case): pass'\n{BROKEN}", encoding="utf-8")
    assert lamps.runpytest_inprocess("--hri-suite=by-hand", *options).ret == 0


def test_files_without_generated_tests_are_imported_where_they_were_asked_for(lamps: pytest.Pytester) -> None:
    (lamps.path / "test_others.py").write_text(BROKEN, encoding="utf-8")
    assert lamps.runpytest_inprocess("--hri-suite=by-hand", ".").ret != 0, "a path was named"
    change(lamps.path, "pytest.ini", "pythonpath = .", "pythonpath = .\nhri_suite = by-hand")
    assert lamps.runpytest_inprocess().ret != 0, "everything is wanted"


@pytest.mark.parametrize(
    ("text", "beside"),
    [
        ("def test_more(hri_case):\n    hri_case.check(hri_case.run())\n", {}),
        ("from test_lamps import test_lamps\n", {}),
        ("from test_lamps import *\n", {}),
        ("import mine\n\n\nclass TestMore(mine.Base):\n    pass\n", {"mine.py": "CLASS"}),
        (
            "from mine import (\n    Base,\n    TestMore,\n)\n",
            {"mine.py": "CLASS\n\n\nclass TestMore(Base):\n    pass\n"},
        ),
        ("import test_lamps\n\nif True:\n    test_more = test_lamps.test_lamps\n", {}),
        (
            "import mine\n\n\nclass CheckMore(mine.Base):\n    pass\n",
            {"mine.py": "CLASS", "pytest.ini": "CLASSES"},
        ),
        ("def test_more(lit):\n    lit.check(lit.run())\n", {"deep/conftest.py": "FIXTURE"}),
        ("def test_more(lit):\n    lit.check(lit.run())\n", {"conftest.py": "IMPORTED", "mine.py": "FIXTURE"}),
        ("def test_more(lit):\n    lit.check(lit.run())\n", {"pytest.ini": "PLUGIN", "mine.py": "FIXTURE"}),
    ],
    ids=[
        *("by name", "imported", "with a star", "base class", "over lines", "assigned", "other names"),
        *("fixture", "its import", "plugin"),
    ],
)
def test_generated_tests_in_disguise_are_found(lamps: pytest.Pytester, text: str, beside: dict[str, str]) -> None:
    parts = {
        "CLASS": "class Base:\n    def test_more(self, hri_case):\n        hri_case.check(hri_case.run())",
        "FIXTURE": "import pytest\n\n\n@pytest.fixture\ndef lit(hri_case):\n    return hri_case\n",
    }
    (lamps.path / "deep").mkdir()
    (lamps.path / "deep" / "test_deep.py").write_text(text, encoding="utf-8")
    for name, content in beside.items():
        if content == "IMPORTED":
            change(lamps.path, name, "from pathlib import Path\n", "from pathlib import Path\n\nfrom mine import lit\n")
        elif content == "PLUGIN":
            change(lamps.path, name, "-p no:hypothesispytest", "-p no:hypothesispytest -p mine")
        elif content == "CLASSES":
            change(lamps.path, name, "[pytest]\n", "[pytest]\npython_classes = Test Check\n")
        else:
            made = content.replace("CLASS", parts["CLASS"]).replace("FIXTURE", parts["FIXTURE"])
            (lamps.path / name).write_text(made, encoding="utf-8")
    listed = nodeids(lamps.runpytest_inprocess("--collect-only", "-q", "--hri-suite=by-hand"))
    assert [line.startswith("deep/") for line in listed].count(True) == 4
    assert len(listed) == 8
