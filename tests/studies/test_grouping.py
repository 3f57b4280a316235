"""Two faults at once, and whether both show."""

from __future__ import annotations

from studies.grouping.combining import Counted, both_show, combined
from studies.localization.faults import Fault

BEFORE = "a = 1\nb = 2\nc = 3\nd = 4\n"


def fault(name: str, old: str, new: str, file: str = "robot.py") -> Fault:
    return Fault(name, "planted", file, BEFORE, BEFORE.replace(old, new))


def test_changes_of_one_file_are_put_together() -> None:
    (both,) = combined(fault("one", "a = 1\n", ""), fault("other", "d = 4\n", "d = 5\ne = 6\n"))
    assert (both.before, both.text) == (BEFORE, "b = 2\nc = 3\nd = 5\ne = 6\n")


def test_changes_of_the_same_or_neighbouring_lines_are_no_pair() -> None:
    assert combined(fault("one", "a = 1", "a = 2"), fault("other", "a = 1", "a = 3")) == ()
    assert combined(fault("one", "a = 1", "a = 2"), fault("other", "b = 2", "b = 3")) == ()


def test_changes_of_two_files_are_both() -> None:
    one, other = fault("one", "a = 1", "a = 2"), fault("other", "a = 1", "a = 3", "hand.py")
    assert combined(one, other) == (one, other)


def test_a_fault_that_hides_the_other_shows_alone() -> None:
    first, second = frozenset({("t", "R1", "")}), frozenset({("t", "R2", "")})
    assert both_show(first, second, first | second)
    assert not both_show(first, second, first)
    assert not both_show(first, first, first)


def test_as_many_causes_as_faults_are_right() -> None:
    cause = (("t",), ("R1",))
    assert Counted(("one",), frozenset(), (cause,)).is_right
    assert not Counted(("one", "other"), frozenset(), (cause,)).is_right
