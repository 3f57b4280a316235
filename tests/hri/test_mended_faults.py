"""Each fault that was mended fails a test that the mended controller passes."""

from __future__ import annotations

from pathlib import Path

import pytest

from controller import finishing
from pytest_hricdv.execution.case import CaseResult
from tests.hri.disturbed import concrete, judged, unknown_violations
from tests.hri.mended_faults import FAULTS, PATCHES, MendedFault, planted
from tests.sampling import mostly_slow


def run(fault: MendedFault) -> CaseResult:
    return judged(concrete(fault.lines, sensing_timeout_s=30.0))


@pytest.mark.parametrize("fault", mostly_slow({fault.name: fault for fault in FAULTS}, 1))
def test_a_mended_fault_that_is_put_back_violates_its_requirements(fault: MendedFault, tmp_path: Path) -> None:
    whole = finishing.discard
    assert not unknown_violations(run(fault))
    with planted(fault.name, tmp_path):
        assert unknown_violations(run(fault)) == fault.violated
    assert finishing.discard is whole
    assert not unknown_violations(run(fault))


def test_each_patch_is_listed_with_the_function_that_has_the_fault() -> None:
    assert sorted(fault.name for fault in FAULTS) == sorted(path.stem for path in PATCHES.glob("*.patch"))
    for fault in FAULTS:
        file, _, function = fault.function.partition(": ")
        text = (PATCHES / f"{fault.name}.patch").read_text(encoding="utf-8")
        assert f"--- a/{file}" in text
        assert f"def {function}(" in (Path(finishing.__file__).parents[1] / file).read_text(encoding="utf-8")
