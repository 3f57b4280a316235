"""Of runs whose behaviour is known, the requirements that say it are suggested; what says nothing is not."""

from __future__ import annotations

from msgspec import structs

from pytest_hricdv.extra.suggestion.candidate import RequirementCandidate
from pytest_hricdv.extra.suggestion.events import Runs
from pytest_hricdv.extra.suggestion.mining import CandidateScore, Tally, find_candidates, list_open_tests, mine, rank
from pytest_hricdv.monitor import Requirement, Vocabulary, evaluate, parse_formula
from tests.extra.suggestion.runs import run, serving, some_runs, views

FORMULAS = [candidate.formula for candidate in find_candidates(views(some_runs()))]
ANSWERED = "always(on(order) & cup -> eventually[3:7](on(served)))"


def test_an_order_is_answered_within_the_longest_time_and_a_margin() -> None:
    assert ANSWERED in FORMULAS
    assert "always(on(order) & !cup -> eventually[0:0.22](on(refused)))" in FORMULAS


def test_numbers_have_bounds_but_checksums_and_time_stamps_have_none() -> None:
    speeds: list[tuple[float, str, str, dict[str, bool | int | float | str]]] = [
        (0.1 * step, "robot", "served", {"x": 0.1 * (step % 3), "y": 0.0, "leds.crc": 7.0 * step, "stamp.sec": step})
        for step in range(1, 30)
    ]
    vocabulary = Vocabulary(signals={}, messages={"served": dict.fromkeys(speeds[0][3], float)})
    runs = Runs([run(f"test-{number}", {}, speeds, 5.0) for number in range(3)], vocabulary)
    formulas = [candidate.formula for candidate in find_candidates(runs)]
    assert any("served.x <=" in formula for formula in formulas)
    assert "always(on(served) -> served.y == 0)" in formulas
    assert not [formula for formula in formulas if "leds.crc" in formula or "stamp" in formula]


def test_all_candidates_hold_in_the_runs_that_they_were_mined_from() -> None:
    runs = views(some_runs())
    requirements = [score.requirement for score in mine(runs, [], []).scores]
    assert len(requirements) > 10
    for log in runs.logs:
        assert [verdict for verdict in evaluate(requirements, log) if verdict.verdict == "Failed"] == []


def test_the_one_that_notices_the_most_faults_comes_first() -> None:
    late = [serving("test-0", (delay_s, 5.0), refuses_after_s=0.2) for delay_s in (9.0, 12.0)]
    best = mine(views(some_runs()), [[run] for run in late], []).rank()[0]
    assert best.faults.bit_count() == 2
    assert "served" in best.candidate.formula or "tap_open" in best.candidate.formula


def test_what_still_waits_at_the_end_of_a_run_is_undecided() -> None:
    complete = serving("cut", (4.0, 5.0))
    before = tuple(message for message in complete.messages if message.time_s <= 40.0)
    runs = [*some_runs(), structs.replace(complete, messages=before, end_s=41.0)]
    pool = mine(views(runs), [], [])
    (answered,) = (score for score in pool.scores if score.candidate.formula.endswith("eventually[3:7](on(served)))"))
    assert list_open_tests([answered], runs) == ["cut"]
    assert answered not in pool.drop({answered.candidate.formula}).scores


def test_what_notices_many_faults_of_a_kind_comes_before_what_notices_one_more() -> None:
    """Others may notice them too: seeded faults stand for those that are not seeded."""
    vocabulary = Vocabulary(messages={topic: {} for topic in "abcdef"})

    def score(topics: str, faults: int) -> CandidateScore:
        first, second = tuple(topics)
        candidate = RequirementCandidate(
            "response", topics, f"on({first})", f"eventually[0:1](on({second}))", frozenset(topics), 9
        )
        formula = parse_formula(candidate.formula, vocabulary)
        return CandidateScore(candidate, Requirement(topics, topics, "", candidate.formula, formula), Tally(), faults)

    many, again, single = score("ab", 0b00001111), score("cd", 0b00001110), score("ef", 0b00010000)
    assert [one.candidate.title for one in rank([single, again, many])] == ["ab", "cd", "ef"]
    assert [one.candidate.title for one in rank([single, again, many], 0b1110)] == ["ab", "ef", "cd"]
