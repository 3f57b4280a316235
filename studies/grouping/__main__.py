"""Count causes of sessions with one fault, and with two at once.

    python -m studies.grouping [--pairs N] [--mutants N] [--projects coffee,vacuum,table] [--diagnose N] [--keep DIR]

Faults are those of `studies/localization/planted.toml` and mutants, drawn with the seed. A pair counts where both
faults show: something fails that fails for the one alone, and something that fails for the other alone.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator, Sequence
from itertools import combinations
from pathlib import Path

from pytest_hricdv.generate.rng import make_rng, shuffle
from pytest_hricdv.results.codec import encode
from pytest_hricdv.results.model import Report
from studies.grouping.combining import Counted, both_show, combined, counted
from studies.localization.faults import Fault, mutants, planted
from studies.localization.projects import PROJECTS, Project
from studies.localization.sessions import prepared, ran


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=int, default=14, metavar="N", help="pairs of each testbench")
    parser.add_argument("--mutants", type=int, default=8, metavar="N", help="mutants of each testbench")
    parser.add_argument("--projects", default="coffee,vacuum,table", metavar="NAME,...")
    parser.add_argument(
        "--diagnose",
        default="",
        metavar="N",
        help="runs of a diagnosis (default: the plugin's; 0: by association alone)",
    )
    parser.add_argument("--seed", type=int, default=0, metavar="N")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="keep the reports")
    options = parser.parse_args()
    measured: list[Counted] = []
    for project in PROJECTS:
        if project.name in options.projects.split(","):
            with tempfile.TemporaryDirectory() as folder:
                measured += _Measuring(project, Path(folder), options).all()
    for count, kind in ((1, "one fault"), (2, "two faults")):
        of_kind = [result for result in measured if len(result.faults) == count]
        right = sum(result.is_right for result in of_kind)
        print(f"{kind}: {right} of {len(of_kind)} have as many causes")


class _Measuring:
    """Sessions of one testbench."""

    def __init__(self, project: Project, folder: Path, options: argparse.Namespace) -> None:
        self._project, self._folder, self._options = project, folder, options

    def all(self) -> Iterator[Counted]:
        """Of faults that some test notices alone, and of pairs of these."""
        options = self._options
        prepared(self._project, self._folder)
        code = self._project.map(self._folder)
        faults = [*planted(self._project.name, code), *mutants(code, options.seed, options.mutants)]
        alone = [(fault, result) for fault in faults if (result := self._counted([fault])) and result.failing]
        yield from (result for _, result in alone)
        pairs = shuffle(make_rng("grouping", options.seed), [*combinations(alone, 2)])
        left = options.pairs
        for (first, one), (second, other) in pairs:
            together = combined(first, second)
            if not left or not together:
                continue
            result = self._counted([first, second], together)
            if result is not None and both_show(one.failing, other.failing, result.failing):
                left -= 1
                yield result

    def _counted(self, faults: Sequence[Fault], changes: Sequence[Fault] = ()) -> Counted | None:
        report = self._ran(*(changes or faults))
        if report is None or not report.tests:
            return None
        result = counted(faults, report)
        name = "+".join(result.faults)
        if self._options.keep:
            self._options.keep.mkdir(parents=True, exist_ok=True)
            (self._options.keep / f"{self._project.name} {name}.json").write_text(encode(report), encoding="utf-8")
        causes = "; ".join(f"{len(tests)} {','.join(requirements)}" for tests, requirements in result.causes)
        print(f"{self._project.name} {name}: {'right' if result.is_right else 'WRONG'}: {causes}", flush=True)
        return result

    def _ran(self, fault: Fault, *others: Fault) -> Report | None:
        diagnose = (f"--hri-diagnose={self._options.diagnose}",) if self._options.diagnose else ()
        for other in others:
            (self._folder / other.file).write_text(other.text, encoding="utf-8")
        try:
            return ran(self._project, self._folder, fault, diagnose)
        finally:
            for other in others:
                (self._folder / other.file).write_text(other.before, encoding="utf-8")


if __name__ == "__main__":
    main()
