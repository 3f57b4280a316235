"""Coverage of the code under test as an LCOV tracefile, which editors show in their margins.

Format: `geninfo(1)`, records TN, SF, BRDA, BRF, BRH, DA, LF, LH. Counts are tests. Waived lines are left out.
"""

from collections.abc import Iterator, Mapping
from typing import Any

from pytest_hricdv.report.hits import FileHits, hits


def lcov(report: Mapping[str, Any]) -> str:
    """The tracefile's text; file names are the report's, relative to the project's root folder."""
    return "".join(f"{line}\n" for file in hits(report) for line in _record(file))


def _record(file: FileHits) -> Iterator[str]:
    yield "TN:"
    yield f"SF:{file.name}"
    if file.branches is not None:
        yield from _branches(file)
    for line, count in sorted(file.lines.items()):
        yield f"DA:{line},{count}"
    yield f"LF:{len(file.lines)}"
    yield f"LH:{sum(count > 0 for count in file.lines.values())}"
    yield "end_of_record"


def _branches(file: FileHits) -> Iterator[str]:
    for line in sorted({arc[0] for arc in file.branches or {}}):
        for number, count in enumerate(file.conditions(line)):
            # A line that was never reached has no count for its branches.
            yield f"BRDA:{line},0,{number},{count if file.lines.get(line) else '-'}"
    counts = (file.branches or {}).values()
    yield f"BRF:{len(counts)}"
    yield f"BRH:{sum(count > 0 for count in counts)}"
