"""`Loop`, the closing loop: strategies propose tests, these run, and what they hit decides what is proposed next.

`ClosureGenerator` runs it, and then `search_violations`. The proposals of a generation are made from the archive alone,
are run in any order on any number of processes, and are merged in the order in which they were proposed. So the same
seed gives the same archive, however many processes run.
"""

from __future__ import annotations

import traceback
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path
from random import Random
from typing import Protocol

from pytest_hricdv._base.error_text import text_of
from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.experiments.budget import Budget
from pytest_hricdv.extra.closing.observation import RunObservation
from pytest_hricdv.extra.closing.records import ClosingEnd
from pytest_hricdv.extra.closing.strategy import Archive, Proposal, Strategy
from pytest_hricdv.generate.abstract import AbstractDraft, AbstractTest, identify
from pytest_hricdv.generate.rng import make_rng, pick_weighted

NAME = "closure"
"""The name of the method and of its suite."""

GENERATION = 8
"""Number of tests per generation: with fewer, strategies learn sooner; with more, more processes are busy."""

STALLED = 10 * GENERATION
"""Number of runs without a newly hit target after which the loop stalls: a fifth of the default budget."""

RECENT = 2 * GENERATION
"""Number of last tests of a strategy from which the bandit estimates what its next tests will hit. Older tests do not
count: what hits targets at the beginning of a loop does not at its end."""

OnlineTests = frozenset[int]
"""The numbers (from 0) of the tests in which interactive agents decide during the run."""


class BatchRunner(Protocol):
    """A function that runs tests, such as `ClosingRuns.run`."""

    def __call__(self, tests: Sequence[AbstractTest], online: OnlineTests, /) -> Iterable[tuple[int, RunObservation]]:
        """The number of each test (from 0) with its observation, in any order.

        A test in which interactive agents decide is only known after its run, and may yield several observations.

        Raises:
            GivenUpError: nothing runs tests any more; the remaining tests have no run.
        """


class GivenUpError(Exception):
    """The process that runs the tests was lost repeatedly; the message says how."""


class LoopError(Exception):
    """The loop makes no sense: every run errs. The text has the first error."""


def share_tests(archive: Archive, names: Sequence[str], count: int, rng: Random) -> dict[str, int]:
    """The number of tests, out of `count`, that each strategy may propose: the bandit.

    For each test a kind of points is drawn in proportion to the open ones, and for this kind a strategy, in proportion
    to how many of its recent tests have hit some.

    Args:
        names: the names of the strategies.
        rng: only its `random()` is used.
    """
    kinds, shares = Counter(point[0] for point in archive.open), dict.fromkeys(names, 0)
    weights = {kind: {name: hit_rate(archive, name, kind) for name in names} for kind in kinds}
    for _ in range(count if names and kinds else 0):
        shares[pick_weighted(rng, weights[pick_weighted(rng, kinds)])] += 1
    return shares


def hit_rate(archive: Archive, strategy: str, kind: str) -> float:
    """The share of a strategy's recent tests that hit a new point of a kind, by Jeffreys' prior (half of one test).

    Tests that were aimed at other kinds count as well: no strategy is told for which kind it was chosen.
    """
    own = (entry for entry in reversed(archive.entries) if entry.strategy == strategy)
    hits = (kind in _kinds(entry.new) for entry in own)
    recent = [*islice(hits, RECENT)]
    return (sum(recent) + 0.5) / (len(recent) + 1.0)


@dataclass
class Loop:
    """The closing loop.

    Args:
        archive: the archive, with the targets; it keeps the runs.
        strategies: the strategies that propose tests.
        runner: runs the tests.
        seed: the master seed.
        budget: the budget of runs and seconds. Runs are what a result depends on; seconds only guard.
        progress: called with the archive after each generation.
        fallback: proposes where the strategies know no more.
        searcher: searches for violations; while nothing pays, that is after `STALLED` runs without a new target, it
            proposes a quarter of each generation.
        search_only: whether it searches for violations until the budget is spent, whatever is closed.
        let_through: within what it gives, Ctrl-C may be raised; elsewhere it would leave the archive in pieces.
    """

    archive: Archive
    strategies: Sequence[Strategy]
    runner: BatchRunner
    seed: int
    budget: Budget
    progress: Callable[[Archive], None] = lambda archive: None
    fallback: Strategy | None = None
    searcher: Strategy | None = None
    search_only: bool = False
    let_through: Callable[[], AbstractContextManager[None]] = nullcontext
    faults: list[str] = field(default_factory=list)
    """Errors of the loop itself, a sentence each: it continues without the strategy that failed."""
    _drafts: list[AbstractDraft] = field(default_factory=list)
    _left_out: set[str] = field(default_factory=set)

    def run(self) -> ClosingEnd:
        """Run the loop to its end. At Ctrl-C, or an error of its own, it keeps what was reached.

        Raises:
            LoopError: every run of the first generation errs.
            Exception: an error before any run has come to its end, from what runs the tests.
        """
        try:
            for number in range(self.budget.runs):
                if ended := self._end_reason():
                    return ended
                proposals = self._proposals(number)
                if not proposals:
                    return "nothing to try"
                self._run(proposals)
                self.progress(self.archive)
        except KeyboardInterrupt:
            return "interrupted"
        except LoopError:
            raise
        except GivenUpError as error:
            self.faults.append(f"the loop ended early: {error}")
            return "error"
        except Exception as error:  # whatever it is, hours of runs are not to be lost for it
            if not self.archive.entries:
                raise
            self.faults.append(f"the loop ended by an error of its own: {_error_text(error)}")
            return "error"
        return self._end_reason() or "runs"

    def _end_reason(self) -> ClosingEnd | None:
        if not self.archive.open and not self.search_only:
            return "closed"
        if self.budget.used >= self.budget.runs:
            return "runs"
        return "seconds" if self.budget.seconds is not None and self.budget.age_s >= self.budget.seconds else None

    def _proposals(self, number: int) -> list[Proposal]:
        """A generation. What one strategy cannot use of its share, the others share."""
        count = min(GENERATION, self.budget.runs - self.budget.used)
        rng = make_rng(NAME, self.seed, number, "shares")
        proposals: list[Proposal] = []
        if self.searcher is not None and (self.search_only or self._stalls()):
            share = count if self.search_only else count // 4
            proposals += self._ask(self.searcher, share, self._rng(number, self.searcher, int(self.search_only)))
        strategies = [strategy for strategy in self.strategies if strategy.name not in self._left_out]
        for attempt in range(len(strategies)):
            names = [strategy.name for strategy in strategies]
            shares = share_tests(self.archive, names, count - len(proposals), rng)
            for strategy in [*strategies]:
                if share := shares[strategy.name]:
                    proposed = self._ask(strategy, share, self._rng(number, strategy, attempt))
                    proposals += proposed
                    if len(proposed) < share:
                        strategies.remove(strategy)
        if self.fallback is not None and len(proposals) < count:
            rng = self._rng(number, self.fallback, 0)
            with self.let_through():
                proposals += self.fallback.propose(self.archive, count - len(proposals), rng)
        return proposals

    def _stalls(self) -> bool:
        last = self.archive.entries[-STALLED:]
        return len(last) == STALLED and not any(entry.new for entry in last)

    def _ask(self, strategy: Strategy, share: int, rng: Random) -> list[Proposal]:
        """The proposals of a strategy; none once it has failed."""
        if strategy.name in self._left_out:
            return []
        try:
            with self.let_through():
                return strategy.propose(self.archive, share, rng)[:share]
        except Exception as error:  # a strategy may fail on an unforeseen testbench; the others can continue
            self._left_out.add(strategy.name)
            self.faults.append(
                f"the strategy {strategy.name!r} failed, and is left out from there on: {_error_text(error)}"
            )
            return []

    def _rng(self, generation: int, strategy: Strategy, attempt: int) -> Random:
        return make_rng(NAME, self.seed, generation, strategy.name, attempt)

    def _run(self, proposals: Sequence[Proposal]) -> None:
        """Run a generation, and merge it in order: of an interrupted one, what has come to its end."""
        tests, observed = self._identify([proposal.draft for proposal in proposals]), dict[int, list[RunObservation]]()
        online = frozenset(place for place, proposal in enumerate(proposals) if proposal.is_online)
        try:
            for place, observation in self.runner(tests, online):
                self.budget.used += 1
                observed.setdefault(place, []).append(observation)
        finally:
            for place in sorted(observed):
                proposal = proposals[place]
                for run in observed[place]:
                    self.archive.add(run, proposal.strategy, proposal.targets)
        if all(entry.observation.error for entry in self.archive.entries):
            raise LoopError(self.archive.entries[0].observation.error)

    def _identify(self, drafts: list[AbstractDraft]) -> list[AbstractTest]:
        """The tests of new drafts: equal ones are numbered among all so far, so each has its own seed."""
        self._drafts += drafts
        return [*identify(NAME, self.seed, self._drafts)[len(self._drafts) - len(drafts) :]]


def search_violations(loop: Loop, ended: ClosingEnd, runs: int | None) -> ClosingEnd:
    """Go on with a search for violations, where nothing is left to close; why all of it ended.

    Args:
        loop: the loop that has ended, with a searcher.
        ended: why.
        runs: maximum number of runs, if as many are left; None: a tenth of those made, and at least a generation.
    """
    budget = loop.budget
    wanted = max(GENERATION, budget.used // 10) if runs is None else runs
    if loop.searcher is None or ended not in ("closed", "nothing to try") or not loop.archive.entries:
        return ended
    budget.runs = min(budget.runs, budget.used + wanted)
    if budget.used >= budget.runs:
        return ended
    end = replace(loop, strategies=(), fallback=None, search_only=True).run()
    return end if end in ("seconds", "interrupted", "error") else ended


def _error_text(error: Exception) -> str:
    """`ValueError: min() iterable argument is empty (closing/strategy.py:12)`: an error, and where it was raised."""
    at = traceback.extract_tb(error.__traceback__)[-1]
    file = Path(at.filename)
    return f"{type(error).__name__}: {text_of(error)} ({file.parent.name}/{file.name}:{at.lineno})"


def _kinds(points: Iterable[Point]) -> frozenset[str]:
    return frozenset(point[0] for point in points)
