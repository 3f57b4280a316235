"""The page of `studies.comparison`, and the causes of the differences that it shows."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from people.ranges import KNOWN

from studies.published import REQUIREMENTS, VERDICTS, PublishedTest, first_orders
from studies.results import Result, Run, agreement, published_result, result

FOOD = ("feed", "clean")
"""Orders for which something is taken and delivered."""

METHODS = {"bdi": "BDI", "mc": "model checking", "pr": "pseudorandom"}
PASSED, FAILED, NC = range(len(VERDICTS))

ALL_FIFTY: Mapping[str, tuple[float, float, tuple[tuple[int, int, int], ...]]] = {
    "bdi": (1897, 71.3, ((983, 184, 730), (819, 925, 153), (1584, 313, 0), (42, 1855, 0))),
    "mc": (1880, 65.2, ((1002, 219, 659), (586, 736, 558), (1495, 384, 1), (198, 1681, 1))),
    "pr": (1892, 56.3, ((690, 135, 1067), (824, 243, 825), (1713, 179, 0), (597, 1295, 0))),
}
"""Method -> started runs, their mean coverage in %, and verdicts of A1 to A4 of all 50 published tests (published)."""

CAUSES = {
    "A1": {
        NC: "Nothing was taken that could be delivered, as neither `feed` nor `clean` was heard. In the original, the "
        "first order is said once, 5 s after the nodes start, and is followed by an empty one a second later: a robot "
        "that does not listen by then never hears it, as in the share of runs above. As it is, this robot listens from "
        "the start, and its bus loses nothing: so it misses by as much as the original has unheard first orders, and "
        "would come nearer only if it did not listen. As it was, first orders are unheard as often as there, of few "
        "tests by chance more or less. As it is, an order is also given up where the dog lies in the robot's place.",
        FAILED: "Food not delivered within 300 s: here never. As it is, the robot looks for a way around others, and "
        "gives an order up before. As it was, it stands for as long as somebody is near, but people and dogs go away. "
        "In the original 469 of the 538 runs that failed it failed A3, too, so something had moved the robot; what "
        "kept it from its place then is not recorded. Its laser stops it while anything is within 0.2 m, be it a thing "
        "that it was pushed to; where the laser is mounted, so where that is so, is not known, and is not built here.",
    },
    "A2": {
        NC: "The robot was not idle. In the original an order lasts longer than here, and unheard orders leave none "
        "after which it can be idle.",
        FAILED: "Idle, and 40 s later not at the charger. As it is, each of these failures is one of A2, and none of "
        "the robot: within the 40 s the person orders something, and the robot is away for it. The person waits for 90 "
        "s and more, the robot is done after 50 s and idle after 80 s. That alone gives the published pattern, below: "
        "few with one order, more with two, most with three. With one order it fails here only where others come first "
        "that the robot cannot do: it is idle before its first order as well. As it was, it fails with one order, too, "
        "beside its charger; the original did not: so its stop test is not what its failures of A2 come from.",
    },
    "A3": {
        FAILED: "More than 0.25 m between two samples. As it is, never: it drives 0.24 m/s at most, samples are 1 s "
        "apart, and the dog that walks makes way. As it was, the dog, which is set somewhere else five times a second "
        "whoever is there, pushes the robot on: that alone gives the published pattern, below, with none where nothing "
        "is ordered from the living room. So the original's samples, 1.2 s apart by the wall's clock, are not the "
        "cause: in the kitchen, where it drives as fast, none failed. How many do depends on the simulator, which "
        "resolves the overlap of robot and dog: here the robot is moved by as much as they overlap.",
    },
    "A4": {
        FAILED: "Turning on the spot and gripping count as standing still, here as there: the requirement is wrong, "
        "and N4 says what was meant.",
    },
}
"""Requirement -> verdict -> why its share differs."""


@dataclass(frozen=True)
class Comparison:
    """Published tests and their runs here.

    Args:
        tests: those that were run, of all methods.
        known: those that they are a sample of.
        copies: runs of each test.
        runs: by what was done with them: as it is, as it was.
        unheard: method -> share of runs, 0 to 1, in which the first order was unheard in the published runs.
        faults: which were switched on for "as it was".
    """

    tests: Sequence[PublishedTest]
    known: Sequence[PublishedTest]
    copies: int
    runs: Mapping[str, Sequence[Run]]
    unheard: Mapping[str, float]
    faults: str

    @property
    def methods(self) -> list[str]:
        """Of the tests."""
        return list(dict.fromkeys(test.method for test in self.tests))

    def results(self, method: str) -> dict[str, Result]:
        """By column: the published one, then those of the runs here."""
        tests = [test for test in self.tests if test.method == method]
        own = {name: result([run for run in runs if run.method == method]) for name, runs in self.runs.items()}
        return {"published": published_result(tests), **own}

    def data(self) -> dict[str, Any]:
        """The figures for JSON."""
        return {
            "copies": self.copies,
            "faults": self.faults,
            "unheard": dict(self.unheard),
            "methods": {
                method: {name: asdict(held) for name, held in self.results(method).items()} for method in self.methods
            },
            "agreement": {
                name: {
                    requirement: agreement(self.tests, runs, place)[0] for place, requirement in enumerate(REQUIREMENTS)
                }
                for name, runs in self.runs.items()
            },
        }

    def text(self) -> str:
        """The page, in Markdown."""
        per_method = len(self.tests) // len(self.methods)
        sample = f" --sample {per_method}" if len(self.tests) < len(self.known) else ""
        head = _HEAD.format(copies=self.copies, count=len(self.tests), sample=sample)
        return "\n".join([head, *self._summary(), *self._verdicts(), *self._agreement()])

    def _summary(self) -> Iterable[str]:
        yield "## Coverage, and what was not checked of A1\n"
        names = ("published", *self.runs)
        yield _table(
            ["", "runs here", *(f"{what}, {name}" for what in ("A1 NC", "coverage") for name in names)],
            [self._summary_row(method) for method in self.methods],
        )
        means = {name: [self.results(method)[name].coverage for method in self.methods] for name in self.runs}
        for name, values in means.items():
            falls = values == sorted(values, reverse=True)
            order = ", ".join(f"{METHODS.get(m, m)} {v:.1f} %" for m, v in zip(self.methods, values, strict=True))
            yield f"- Mean coverage {name}: {order}: {'in' if falls else 'not in'} the published order."
        yield ""
        yield "Of all tests that are known, A1 is not checked where neither `feed` nor `clean` is heard: so by their"
        yield "steps, and by the share of first orders that the original robot did not hear. That shows where the first"
        yield "order is the only one that it can do; of later orders, it heard nearly all.\n"
        yield _table(
            ["", "A1 NC, published", "by steps", "and unheard first orders", "first orders unheard"],
            [self._step_row(method) for method in self.methods],
        )
        yield self._confirmed()

    def _step_row(self, method: str) -> list[str]:
        own = [test for test in self.known if test.method == method]
        runs, unmoved, share = first_orders(own)[method]
        shares = [published_result(own).share(0, NC), unchecked(own, 0.0), unchecked(own, share)]
        return [METHODS.get(method, method), *(f"{held:.1f} %" for held in shares), f"{unmoved} of {runs} runs"]

    def _confirmed(self) -> str:
        """In how many runs A1 was checked where it is to be."""
        steps = {(test.method, test.number): test.steps for test in self.tests}
        said = []
        for name, runs in self.runs.items():
            heard = [steps[run.method, run.number][run.is_unheard :] for run in runs]
            held = sum(
                (run.verdicts[0] != VERDICTS[NC]) == any(step in FOOD for step in orders)
                for run, orders in zip(runs, heard, strict=True)
            )
            said.append(f"{held} of {len(runs)} runs {name}")
        return f"In {', and in '.join(said)}, A1 was checked if and only if one of them was ordered and heard.\n"

    def _summary_row(self, method: str) -> list[str]:
        held = self.results(method)
        ncs = [f"{column.share(0, NC):.1f} %" for column in held.values()]
        means = [f"{column.coverage:.1f} %" for column in held.values()]
        return [METHODS.get(method, method), str(held[next(iter(self.runs))].runs), *ncs, *means]

    def _verdicts(self) -> Iterable[str]:
        for place, requirement in enumerate(REQUIREMENTS):
            yield f"## {requirement}\n"
            rows = []
            for method in self.methods:
                for name, held in self._columns(method):
                    shares = [f"{held.verdicts[place][v]} ({held.share(place, v):.1f} %)" for v in range(len(VERDICTS))]
                    rows.append([METHODS.get(method, method), name, str(held.runs), *shares])
            yield _table(["", "", "runs", *VERDICTS], rows)
            for verdict, why in CAUSES[requirement].items():
                yield f"- {VERDICTS[verdict]}: {why}"
            yield ""
            if requirement != "A4":
                yield self._by_orders(place)

    def _by_orders(self, place: int) -> str:
        """Failed of checked, by how many orders of a test the robot can do, and where they lead it."""
        groups = {
            f"{count}": [test for test in self.tests if sum(step in KNOWN for step in test.steps) == count]
            for count in (1, 2, 3)
        }
        groups["none in the living room"] = [test for test in self.tests if not set(FOOD) & set(test.steps)]
        rows = []
        for title, own in groups.items():
            names = {(test.method, test.number) for test in own}
            here = [result([run for run in runs if (run.method, run.number) in names]) for runs in self.runs.values()]
            rows.append([title, *(_of_checked(held, place) for held in (published_result(own), *here))])
        return _table(["orders that it can do", "published", *self.runs], rows)

    def _columns(self, method: str) -> Iterable[tuple[str, Result]]:
        if method in ALL_FIFTY:
            runs, coverage, verdicts = ALL_FIFTY[method]
            yield "published, all 50 tests", Result(int(runs), verdicts, coverage)
        for name, held in self.results(method).items():
            yield ("published, these tests" if name == "published" else name), held

    def _agreement(self) -> Iterable[str]:
        yield "## Agreement, test by test\n"
        yield "In how many published runs a test's verdict is the one that it has here in most runs. The last column is"
        yield "the verdict that it has there in most runs: no more can agree.\n"
        rows = []
        for place, requirement in enumerate(REQUIREMENTS):
            own = [agreement(self.tests, runs, place) for runs in self.runs.values()]
            rows.append([requirement, *(f"{here:.0f} %" for here, _ in own), f"{own[0][1]:.0f} %"])
        yield _table(["", *self.runs, "at most"], rows)


_HEAD = """# This robot beside the published one

Made by `python -m studies.comparison --copies {copies}{sample}`. Published tests of the home-care case, which
`published.json` has with what came of their runs, are run on this robot: {count} tests, runs of each: {copies}, *as it
is*; and as often *as it was*, with the published faults switched on (`carebot.config.Faults`), the first order unheard
as often as there, and the dog that jumps. Published figures are of the runs that started.
"""


def unchecked(tests: Sequence[PublishedTest], unheard: float) -> float:
    """In how many % of runs A1 is not checked, if a share of the first orders is unheard, and nothing else differs."""
    held = 0.0
    for test in tests:
        first, later = test.steps[:1], test.steps[1:]
        if not any(step in FOOD for step in later):
            held += unheard if any(step in FOOD for step in first) else 1.0
    return 100.0 * held / len(tests)


def _of_checked(held: Result, place: int) -> str:
    passed, failed, _ = held.verdicts[place]
    checked = passed + failed
    return f"{failed} of {checked} ({100 * failed / checked:.0f} %)" if checked else "-"


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    listed = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(row) + " |" for row in listed) + "\n"
