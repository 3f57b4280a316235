"""The guide for contributors keeps up with the code: targets, files, and the roles of features."""

from __future__ import annotations

import re

from pytest_hricdv import registry
from studies.site.pages import ROOT

GUIDE = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")


def test_each_role_of_a_feature_is_described() -> None:
    described = set(re.findall(r"^- `(\w+)`", registry.__doc__ or "", re.MULTILINE))
    assert {role for roles in registry.FEATURES.values() for role in roles} <= described


def test_features_offer_each_name_of_the_table() -> None:
    rows = re.findall(r"^\| ((?:`\w+`(?:, )?)+) \| `(\w+)` \|", GUIDE, re.MULTILINE)
    assert len(rows) > 5
    for names, role in rows:
        assert [name for name in re.findall(r"\w+", names) if not registry.offers(role, name)] == []


def test_files_and_folders_that_it_names_are_there() -> None:
    named = re.findall(r"`((?:tests|pytest_hricdv|studies|sim|controller|models_bdi|benchmarks)/[\w./*-]*)", GUIDE)
    assert len(named) > 40
    assert [path for path in named if "NAME" not in path and not [*ROOT.glob(path.rstrip("/"))]] == []


def test_targets_of_make_that_it_names_are_there() -> None:
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    assert set(re.findall(r"`make ([a-z-]+)", GUIDE)) <= targets
