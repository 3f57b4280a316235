"""Requirements of other tools, there and back: whether all ids of ReqIF files survive.

    python -m studies.exchange FOLDER

Each `.reqif` and `.reqifz` below the folder, such as a checkout of strictdoc-project/reqif, is read as the requirements
of `hricdv evidence`, and evidence of nothing is written for it, as ReqIF, `needs.json` and CSV; each is read again.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from pytest_hricdv.extra.evidence import outputs
from pytest_hricdv.extra.evidence.requirement_lists import read_requirements
from pytest_hricdv.extra.evidence.rows import gather_evidence
from pytest_hricdv.results.codec import ReportError
from tests.report import sample


def round_trips(folder: Path) -> Iterator[str]:
    """What becomes of each file: a line for those that are refused or lose an id, and one for all."""
    report = sample.report()
    facts, files, count = outputs.facts_of(report), 0, 0
    with TemporaryDirectory() as scratch:
        for file in sorted(path for path in folder.rglob("*") if path.suffix in (".reqif", ".reqifz")):
            try:
                listed = read_requirements(file)
            except ReportError as error:
                yield f"refused: {error}"
                continue
            rows = gather_evidence(report, listed)
            texts = {
                "list.reqif": outputs.reqif(rows, facts),
                "list.json": outputs.needs_json(rows, facts),
                "list.csv": outputs.requirements_csv(rows),
            }
            for name, text in texts.items():
                target = Path(scratch, name)
                target.write_text(text, encoding="utf-8")
                if [entry.id for entry in read_requirements(target)] != [row.id for row in rows]:
                    yield f"lost: {file}: ids in {name}"
            files, count = files + 1, count + len(listed)
    yield f"{files} files, {count} ids"


if __name__ == "__main__":
    for line in round_trips(Path(sys.argv[1])):
        print(line)
