"""Reports that were edited: each contradiction is an error with its place."""

from __future__ import annotations

import json
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pytest_hricdv.coverage.code_map import Bits
from pytest_hricdv.results import journal
from pytest_hricdv.results.codec import ReportError, canonical, load
from pytest_hricdv.results.report_builder import rebuild
from tests.results.reports import STATEMENTS, report, result

Data = dict[str, Any]


def written(folder: Path, edit: Callable[[Data], object]) -> Path:
    """A report of two tests that were run, edited."""
    bits = Bits(3, 1).share(STATEMENTS)
    tests = [result(number, outcome="passed", code=bits, cross={"turn": (("1", "kept"),)}) for number in (1, 2)]
    data = json.loads(canonical(report(tests)))
    edit(data)
    path = folder / "report.json"
    path.write_text(json.dumps(data))
    return path


def test_a_report_that_was_not_edited_is_read(tmp_path: Path) -> None:
    assert len(load(written(tmp_path, lambda data: None)).tests) == 2


@pytest.mark.parametrize("deep", ["[" * 100_000, "[" * 100_000 + "]" * 100_000, '{"a":' * 900 + "1" + "}" * 900])
@pytest.mark.parametrize("kind", ["declared", "finished"])
def test_a_journal_of_deep_json_is_refused(tmp_path: Path, deep: str, kind: str) -> None:
    whole = canonical(report([])).replace("\n", "")
    declared = deep if kind == "declared" else whole
    path = tmp_path / journal.NAME
    for record in (
        f'{{"record":"declared","report":{declared}}}',
        f'{{"record":"finished","nodeid":"x","at_s":1,"result":{deep}}}',
    ):
        body = record.encode()
        with path.open("ab") as file:
            file.write(b"%08x %d %s\n" % (zlib.crc32(body), len(body), body))
    read = journal.read(path)
    if kind == "finished" and read.damaged:  # as a torn record: the test it is of runs again
        assert rebuild(read)[0].tests == ()
    else:
        with pytest.raises(ValueError, match=r"no test had begun|nested too deeply"):
            rebuild(read)


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (lambda data: data["tests"][1].update(suite="other"), "report's suites, got 'other' - at `$.tests[1].suite`"),
        (lambda data: data["tests"][1].update(suite="../up"), "Expected `str` matching regex"),
        (lambda data: data["suites"][0].update(name="a/b"), "Expected `str` matching regex"),
        (lambda data: data["suites"].append(data["suites"][0]), "got 'rl' again - at `$.suites[1].name`"),
        (lambda data: data["tests"].pop(), "expected 1, as there are tests, got 2 - at `$.selected`"),
        (lambda data: data.update(reported=1), "expected 2, as there are tests, got 1 - at `$.reported`"),
        (lambda data: data["tests"].append(data["tests"][0]), "again - at `$.tests[2].nodeid`"),
        (lambda data: data["tests"][0]["requirements"].pop("R2"), "got none on 'R2' - at `$.tests[0].requirements`"),
        (
            lambda data: data["tests"][0]["requirements"].update(R9=data["tests"][0]["requirements"]["R1"]),
            "got 'R9' - at `$.tests[0].requirements`",
        ),
        (
            lambda data: data["tests"][0]["requirements"]["R1"].update(verdict="Failed"),
            "expected none that passes: the run violates a requirement, or has a fault - at `$.tests[0].outcome`",
        ),
        (
            lambda data: (
                data["tests"][0]["requirements"]["R1"].update(verdict="Failed"),
                data["tests"][0].update(outcome="known-violation"),
            ),
            "no known violation is of 'R1' - at `$.tests[0].outcome`",
        ),
        (lambda data: data["tests"][0].update(errors=["it hangs"]), "or has a fault - at `$.tests[0].outcome`"),
        (lambda data: data["tests"][0]["code"].update(bits=["zz", None]), "at `$.tests[0].code.bits[0]`"),
        (lambda data: data["tests"][0]["code"].update(bits=["-0x1", None]), "at `$.tests[0].code.bits[0]`"),
        (lambda data: data["tests"][0]["code"].update(bits=["0x20", None]), "expected bits of the 5 statements"),
        (lambda data: data["tests"][0]["code"].update(bits=["0x1", "0x4"]), "expected bits of the 2 branches"),
        (lambda data: data.update(shard="x/y"), "Expected `str` matching regex"),
        (lambda data: data.update(shard="1/99999999"), "Expected `str` matching regex"),
        (lambda data: data.update(shard="3/2"), "got '3/2' - at `$.shard`"),
        (lambda data: data.update(known_until={"R2": "soon"}), "YYYY-MM-DD, got 'soon' - at `$.known_until.R2`"),
        (
            lambda data: data["code_under_test"]["waivers"][0].update(line=9),
            "got 'robot/b.py', line 9 - at `$.code_under_test.waivers[0]`",
        ),
        (
            lambda data: data["code_under_test"]["waivers"][0].update(file="c.py"),
            "got 'c.py', line 2 - at `$.code_under_test.waivers[0]`",
        ),
        (lambda data: data["code_under_test"]["waivers"][0].pop("reason"), "missing required field `reason`"),
        (lambda data: data["tests"][0]["cross"].update(turn=[["1"]]), "a part for each coordinate, got ('1',)"),
        (lambda data: data["tests"][0]["cross"].update(turn=[["1", "x"]]), "at `$.tests[0].cross`"),
        (lambda data: data["tests"][0]["cross"].update(other=[]), "got 'other' - at `$.tests[0].cross`"),
        (
            lambda data: data["cross_products"]["turn"].update(
                coordinates=[{"name": str(n), "bins": [*map(str, range(99))]} for n in range(9)]
            ),
            "more than 100000 bins - at `$.cross_products.turn`",
        ),
        (
            lambda data: data["cross_products"]["turn"]["coordinates"][0].update(bins=["1", "1"]),
            "coordinate 'leg' has a value twice, or one named '*': ('1', '1') - at `$.cross_products.turn`",
        ),
        (
            lambda data: data["cross_products"]["turn"].update(coordinates=[]),
            "cross product: expected at least one coordinate - at `$.cross_products.turn`",
        ),
        (lambda data: data.update(wall_s=10**400), "expected a number of at most 19 digits, got one of 401"),
    ],
)
def test_an_edited_report_is_refused_with_its_place(
    tmp_path: Path, edit: Callable[[Data], object], message: str
) -> None:
    path = written(tmp_path, edit)
    with pytest.raises(ReportError) as raised:
        load(path)
    assert str(raised.value).startswith(f"{path}:")
    assert message in str(raised.value)
    assert len(str(raised.value)) <= 1000
