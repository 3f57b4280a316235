"""Of runs whose behaviour is known, the requirements that say it are suggested; what says nothing is not."""

from __future__ import annotations

from msgspec import structs

from pytest_hricdv.extra.suggestion.candidate import Candidate
from pytest_hricdv.extra.suggestion.checking import Tally
from pytest_hricdv.extra.suggestion.learning import Evidence, learnt, unmoved
from pytest_hricdv.extra.suggestion.mining import candidates, parsed
from pytest_hricdv.extra.suggestion.ranking import Rated, ranked
from pytest_hricdv.extra.suggestion.views import Runs
from pytest_hricdv.monitor import Vocabulary, evaluate
from tests.extra.suggestion.runs import run, serving, some_runs, views


def formulas() -> list[str]:
    return [one.candidate.formula for one in candidates(views(some_runs()))]


def test_an_order_is_answered_within_the_longest_time_and_a_margin() -> None:
    made = formulas()
    assert "always(on(order) & cup -> eventually[3:7](on(served)))" in made
    assert "always(on(order) & !cup -> eventually[0:0.22](on(refused)))" in made


def test_what_is_served_is_served_once_after_an_order() -> None:
    assert "always(on(served) -> previously(!on(served) since on(order)))" in formulas()


def test_a_field_that_counts_is_a_relation() -> None:
    assert "always(on(served) -> served.number == count(on(served)))" in formulas()


def test_what_never_changes_crowds_out_no_bound_and_a_checksum_is_a_content() -> None:
    """A speed has six numbers, of which a base on wheels uses two: the others are 0, and as large as each other."""
    still = {f"angular.{axis}": 0.0 for axis in "xy"} | {f"linear.{axis}": 0.0 for axis in "yz"}
    speeds = [
        (
            0.1 * step,
            "robot",
            "served",
            {
                **still,
                "linear.x": 0.1 * (step % 3),
                "leds.crc": 7.0 * step,
                "colours.crc": (3718166540.0, 4011220000.0)[step % 2],
                "stamp.sec": step,
            },
        )
        for step in range(1, 30)
    ]
    vocabulary = Vocabulary(signals={}, messages={"served": dict.fromkeys(speeds[0][3], float)})
    runs = Runs.of([run(f"test-{number}", {}, speeds, 5.0) for number in range(3)], vocabulary)
    made = [one.candidate.formula for one in candidates(runs)]
    assert any("served.linear.x <=" in formula for formula in made)
    assert "always(on(served) -> served.linear.y == 0)" in made
    assert not [formula for formula in made if "angular.x <= served.angular.y" in formula]
    assert not [formula for formula in made if "leds.crc" in formula or "stamp" in formula]
    assert "always(on(served) -> served.colours.crc == 3718166540 | served.colours.crc == 4011220000)" in made


def test_nothing_is_asked_of_a_person() -> None:
    asked = [formula.partition(" -> ")[2] for formula in formulas()]
    assert not [text for text in asked if text.startswith("eventually") and ("on(order)" in text or "(cup)" in text)]


def test_all_candidates_hold_in_the_runs_that_they_were_learnt_of() -> None:
    runs = views(some_runs())
    made = candidates(runs)
    assert len(made) > 20
    for log in runs.logs:
        verdicts = evaluate([one.requirement for one in made], log)
        assert [verdict.requirement for verdict in verdicts if verdict.verdict == "Failed"] == []


def test_the_one_that_notices_the_most_faults_comes_first() -> None:
    late = tuple(serving("test-0", (delay_s, 5.0), refuses_after_s=0.2) for delay_s in (9.0, 12.0))
    evidence = Evidence(views(some_runs()), ((late[0],), (late[1],)))
    best = learnt(evidence).ranked[0]
    assert best.faults.bit_count() == 2
    assert "served" in best.candidate.formula or "tap_open" in best.candidate.formula


def test_a_further_run_refutes() -> None:
    first = learnt(Evidence(views(some_runs())))
    assert any("eventually[3:7](on(served))" in one.candidate.formula for one in first.rated)
    left = first.without([serving("further", (9.0, 5.0), refuses_after_s=0.2)])
    assert left.refuted > 0
    assert not any("eventually[3:7](on(served))" in one.candidate.formula for one in left.rated)


def test_signals_that_no_fault_moves_are_none_of_the_robots() -> None:
    own = {run.test: run for run in some_runs()}
    late = [(serving("test-0", (delay_s, 5.0), refuses_after_s=0.2),) for delay_s in (7.0, 8.0, 9.0, 10.0, 11.0)]
    assert unmoved(own, late) == {"cup"}


def test_what_still_waits_at_the_end_of_a_run_is_told_and_what_is_refuted_by_going_on_is_left_out() -> None:
    whole = serving("cut", (4.0, 5.0))
    before = tuple(message for message in whole.messages if message.time_s <= 40.0)
    runs = [*some_runs(), structs.replace(whole, messages=before, end_s=41.0)]
    found = learnt(Evidence(views(runs)))
    (served,) = (one for one in found.rated if one.candidate.formula.endswith("eventually[3:7](on(served)))"))
    assert found.undecided([served], runs) == ["cut"]
    left = found.without_formulas({served.candidate.formula})
    assert left.refuted == found.refuted + 1
    assert served not in left.rated
    assert len(left.rated) == len(found.rated) - 1


def test_what_notices_many_faults_of_a_kind_comes_before_what_notices_one_more() -> None:
    """Others may notice them too: seeded faults stand for those that are not seeded."""
    vocabulary = Vocabulary(messages={topic: {} for topic in "abcdef"})

    def rated(topics: str, faults: int) -> Rated:
        first, second = topics
        candidate = Candidate(
            "response", topics, f"on({first})", f"eventually[0:1](on({second}))", frozenset(topics), 9
        )
        made = parsed(candidate, Runs.of([], vocabulary))
        assert made is not None
        return Rated(made, Tally(), faults, faults, 0)

    many, again, single = rated("ab", 0b00001111), rated("cd", 0b00001110), rated("ef", 0b00010000)
    assert [one.candidate.title for one in ranked([single, again, many])] == ["ab", "cd", "ef"]
    assert [one.candidate.title for one in ranked([single, again, many], taken=0b1110)] == ["ab", "ef", "cd"]
