"""Where a failing run and a passing one part, and how much of the former happens in both."""

from __future__ import annotations

from pytest_hricdv.extra.diagnosis.divergence import find_divergence
from pytest_hricdv.extra.diagnosis.runs import RunEvent, RunSummary


def run(*events: tuple[float, str, str], **violated: float) -> RunSummary:
    made = tuple(
        RunEvent(time_s=time_s, stream=stream, value=value, text=f"{stream} {value}")
        for time_s, stream, value in events
    )
    return RunSummary(violated=tuple(violated), events=made, times_s=violated)


def texts(events: tuple[object, ...]) -> list[str]:
    return [event.text for event in events]  # type: ignore[attr-defined]


def test_the_first_event_that_differs_of_any_stream() -> None:
    failing = run((1, "state", "ask"), (2, "hand", "open"), (3, "state", "go"), (4, "hand", "shut"), R2=3.5)
    passing = run((1, "state", "ask"), (2, "hand", "open"), (3, "state", "wait"), (4, "hand", "shut"))
    parting = find_divergence(failing, passing)
    assert parting.at == 2
    assert texts(parting.failing) == ["state ask", "hand open", "state go", "R2 is violated", "hand shut"]
    assert texts(parting.passing) == ["state ask", "hand open", "state wait", "hand shut"]


def test_what_repeats_and_what_comes_later_is_no_difference() -> None:
    failing = run((1, "beat", ""), (2, "beat", ""), (2.5, "state", "go"), (3, "beat", ""), (4, "state", "stop"))
    passing = run((1, "beat", ""), (4.5, "state", "go"), (6, "state", "stop"))
    assert find_divergence(failing, passing).at is None


def test_what_only_one_of_them_does() -> None:
    failing = run((1, "state", "go"))
    passing = run((1, "state", "go"), (2, "state", "stop"))
    parting = find_divergence(failing, passing)
    assert (parting.at, texts(parting.failing), texts(parting.passing)) == (1, ["state go"], ["state go", "state stop"])


def test_runs_without_events_show_the_violation() -> None:
    parting = find_divergence(run(R1=2.0), run())
    assert (parting.at, texts(parting.failing), parting.passing) == (None, ["R1 is violated"], ())
