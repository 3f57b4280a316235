"""The guide for contributors keeps up with the code: targets, folders of tests, and the faces of optional parts."""

from __future__ import annotations

import re

from pytest_hricdv.registry import FEATURES
from studies.site.pages import ROOT

GUIDE = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")


def test_each_face_of_a_part_has_its_row() -> None:
    rows = re.findall(r"^\| `(\w+)\.py` \| `(\w+)", GUIDE, re.MULTILINE)
    assert {face for face, _ in rows} == {face for faces in FEATURES.values() for face in faces}
    for face, name in rows:
        offered = [f"pytest_hricdv/extra/{part}/{face}.py" for part, faces in FEATURES.items() if face in faces]
        if name.isupper():
            assert any(f"\n{name} = " in (ROOT / path).read_text(encoding="utf-8") for path in offered), (face, name)


def test_files_and_folders_that_it_names_are_there() -> None:
    named = re.findall(r"`((?:tests|pytest_hricdv|studies|sim|controller|models_bdi|benchmarks)/[\w./*-]*)", GUIDE)
    assert len(named) > 40
    assert [path for path in named if "NAME" not in path and not [*ROOT.glob(path.rstrip("/"))]] == []


def test_targets_of_make_that_it_names_are_there() -> None:
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    assert set(re.findall(r"`make ([a-z-]+)", GUIDE)) <= targets
