"""The first requirements of a draft."""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv.extra.draft.drafted import Draft
from pytest_hricdv.extra.draft.findings import Place

ANSWER_S = 60.0
"""Within which the robot is to answer (chosen: somebody who waits for a robot for longer has left)."""

STAY_S = 60.0
"""For which the robot may be in one state (chosen: likewise)."""


def requirement_ids(draft: Draft) -> dict[str, str]:
    """Subject of each requirement (`answer order`, `state moving`) -> its id."""
    subjects = [subject for subject, _, _ in _asked(draft)]
    subjects += [f"state {state}" for state in draft.states]
    if draft.findings.said:
        subjects.append("said" if draft.things else "speaks")
    # Where the first runs refuted all that was asked, nobody knows whether the code may end before the person leaves.
    silent = ["works", "ends"] if draft.ros is None and not draft.has_dropped_all else ["ends"]
    subjects += silent if draft.tells_presence else []
    return {subject: f"R{number}" for number, subject in enumerate(subjects, 1)}


def requirements(draft: Draft) -> str:
    """The file of requirements; one that did not hold in the first runs is a question, and stands as a comment."""
    lines = [
        "# always(a -> b) is checked whenever a holds; if it never holds in a test, the verdict is NC, not checked.",
        "# These are a draft: they held in the first runs, and nobody has asked for them yet.",
        "# That no exception ends the code is checked in each run, without a requirement.",
    ]
    ids = requirement_ids(draft)
    answers = " | ".join(f"on({message.topic})" for message in draft.answers)
    for subject, asked, place in _asked(draft):
        title = f"The robot says something within {ANSWER_S:g} s after {subject.removeprefix('answer ')}"
        formula = f"always({asked} -> eventually[0:{ANSWER_S:g}]({answers}))"
        lines += _requirement(
            ids[subject], title, formula, str(place), subject in draft.dropped, "is it to be answered"
        )
    state = draft.findings.state
    for name in draft.states:
        subject = f"state {name}"
        bound = STAY_S
        title = f"The robot is not in {name} for more than {bound:g} s"
        topic = state.partition(".")[0]
        formula = (
            f"always(on({topic}) & {state} == '{name}' -> eventually[0:{bound:g}](on({topic}) & {state} != '{name}'))"
        )
        place = next(s.place for m in draft.findings.machines if m.told for s in m.states if s.name == name)
        is_dropped = subject in draft.dropped
        lines += _requirement(ids[subject], title, formula, str(place), is_dropped, "how long may it last")
    if "said" in ids:
        lines += _flood(ids["said"], draft)
    if "speaks" in ids:
        lines += _speaks(ids["speaks"], draft)
    if "ends" in ids:
        lines += _silent(ids, draft)
    return "\n".join(lines) + "\n"


def _asked(draft: Draft) -> Iterator[tuple[str, str, Place]]:
    """What is to be answered: the subject, its condition, and its place; each kind of a message by itself."""
    for thing in draft.things if draft.answers else ():
        topic = thing.message.topic
        place = thing.message.uses[0] if thing.message.uses else thing.message.place
        part = next((part for part in thing.message.fields if part.kind == "str" and len(part.values) > 1), None)
        if part is None:
            yield f"answer {_words(topic)}", f"on({topic})", place
            continue
        for value in part.values:
            quoted = value.text.replace("'", "\\'")
            yield (
                f"answer {_words(topic)} {value.text}",
                f"on({topic}) & {topic}.{part.name} == '{quoted}'",
                value.place,
            )


def _flood(name: str, draft: Draft) -> list[str]:
    """What holds of each robot that does not go mad: it does not say the same twice at one instant."""
    message = draft.answers[0]
    heard = " | ".join(f"on({thing.message.topic})" for thing in draft.things)
    title = f"Before {_words(message.topic)}, the robot has heard something"
    formula = f"always(on({message.topic}) -> once({heard}))"
    return _requirement(name, title, formula, str(message.place), "said" in draft.dropped, "may it come of itself")


def _speaks(name: str, draft: Draft) -> list[str]:
    """What can be asked of a robot that nobody has to tell anything."""
    answers = " | ".join(f"on({message.topic})" for message in draft.answers)
    title = f"While a person is there, the robot says something every {ANSWER_S:g} s"
    formula = f"always(person_is_there -> eventually[0:{ANSWER_S:g}]({answers} | not person_is_there))"
    place = str(draft.answers[0].place)
    return _requirement(name, title, formula, place, "speaks" in draft.dropped, "may it be silent for longer")


def _silent(ids: dict[str, str], draft: Draft) -> list[str]:
    """What can be asked of a robot of which nobody knows what it says."""
    if draft.ros is not None:
        formula = "always(person_is_there -> eventually[0:900](not person_is_there))"
        return _requirement(ids["ends"], "A visit ends within 900 s", formula, "TODO: ask for more", False, "")
    works = "always(person_is_there -> robot_works)"
    title, is_dropped = "The code works as long as the person is there", "works" in draft.dropped
    place = draft.findings.package
    lines = _requirement(ids["works"], title, works, place, is_dropped, "may it end before") if "works" in ids else []
    ends = "always(person_is_there -> eventually[0:900](not person_is_there | not robot_works))"
    return lines + _requirement(ids["ends"], "A visit ends within 900 s", ends, "TODO: ask for more", False, "")


def _requirement(name: str, title: str, formula: str, place: str, is_dropped: bool, question: str) -> list[str]:
    lines = [f"[{name}]", f'title = "{title}"', f'formula = "{formula}"']
    if is_dropped:
        lines = [
            f"# TODO: {question}? In the first runs this did not hold, or was not seen.",
            *(f"# {line}" for line in lines),
        ]
    return ["", f"# {place}", *lines]


def _words(topic: str) -> str:
    return topic.replace("_", " ")
