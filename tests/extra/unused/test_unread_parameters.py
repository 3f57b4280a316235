"""A parameter that no run of a session reads is named; one that any of them reads is not."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import pytest

from pytest_hricdv.execution.influence import ParameterLog
from tests.plugin.project import report

READS: dict[str, Callable[[Mapping[str, float]], object]] = {
    "by name": lambda run: run["a"],
    "with a default": lambda run: run.get("a", 0.0),
    "as arguments": lambda run: dict(**run),
    "in a display": lambda run: {**run},
    "as a dictionary": dict,
    "as pairs": lambda run: [value for _, value in run.items()],
    "as values": lambda run: max(run.values()),
    "with others": lambda run: run | {"b": 1.0},  # type: ignore[operator]
    "as a copy": lambda run: run.copy(),  # type: ignore[attr-defined]
}


@pytest.mark.parametrize("read", READS.values(), ids=READS)
def test_each_way_to_read_a_parameter_is_noted(read: Callable[[Mapping[str, float]], object]) -> None:
    parameters = ParameterLog({"a": 1.0})
    assert parameters == {"a": 1.0}
    assert "a" in parameters
    assert parameters.unread == {"a"}
    read(parameters)
    assert not parameters.unread


def test_a_parameter_that_no_run_reads_is_named(lamps: pytest.Pytester) -> None:
    conftest = lamps.path / "conftest.py"
    declared = 'run={"patience_s": Uniform(5.0, 8.0, "s")'
    text = conftest.read_text(encoding="utf-8")
    assert declared in text
    conftest.write_text(text.replace(declared, declared + ', "glare": Uniform(0.0, 1.0)'), encoding="utf-8")
    result = lamps.runpytest_inprocess("--hri-suite=by-hand")
    assert result.ret == 0
    result.stdout.fnmatch_lines("*nothing read the parameter glare in any of 4 runs, so its values test nothing: *")
    assert report(lamps.path)["never_read"] == ["glare"]
    result = lamps.runpytest_inprocess("--hri-suite=by-hand", "-k", "cellar")
    assert "nothing read the parameter" not in result.stdout.str(), "other tests may read it"
    assert "never_read" not in report(lamps.path)
