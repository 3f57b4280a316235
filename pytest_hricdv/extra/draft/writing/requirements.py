"""The first requirements of a draft."""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv.extra.draft.found.findings import Message, Place
from pytest_hricdv.extra.draft.writing.drafted import Draft

ANSWER_S = 60.0
"""Within which the robot is to answer (chosen: somebody who waits for a robot for longer has left)."""

STAY_S = 60.0
"""For which the robot may be in one state (chosen: likewise)."""

SKIPPED = "# The state is looked at each 0.1 s. Where this fails, it may have been in another one for less."
"""Under a requirement of what a draft sees from time to time only."""


def requirement_ids(draft: Draft) -> dict[str, str]:
    """Subject of each requirement (`answer order`, `state moving`) -> its id."""
    subjects = [subject for subject, _, _ in _asked(draft)]
    subjects += [f"state {state}" for state in draft.states]
    if draft.findings.said:
        subjects.append("said" if draft.things else "speaks")
    # Where the first runs refuted all that was asked, nobody knows whether the code may end before the person leaves.
    subjects += ["once for each"] if draft.things and draft.answers else []
    subjects += [f"goes {state}" for state in _ways(draft)]
    subjects += [f"twice {message.topic}" for message in draft.findings.said]
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
    if "once for each" in ids:
        lines += _once_for_each(ids["once for each"], draft)
    for state, (targets, place) in _ways(draft).items():
        lines += _goes(ids[f"goes {state}"], draft, state, targets, place)
    for message in draft.findings.said:
        lines += _twice(ids[f"twice {message.topic}"], draft, message)
    if "works" in ids:
        lines += _works(ids["works"], draft)
    if "ends" in ids:
        lines += _ends(ids["ends"], draft)
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
    """What holds of each robot that speaks only when it was spoken to."""
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


def _once_for_each(name: str, draft: Draft) -> list[str]:
    """What holds of each robot that answers what it hears, and no more."""
    says = " | ".join(f"on({message.topic})" for message in draft.answers)
    said = " + ".join(f"count(on({message.topic}))" for message in draft.answers)
    heard = " + ".join(f"count(on({thing.message.topic}))" for thing in draft.things)
    title = "The robot says no more often something than it has heard something"
    is_dropped = "once for each" in draft.dropped
    place, question = str(draft.answers[0].place), "may it say more than one thing for what it hears"
    return _requirement(name, title, f"always({says} -> {said} <= {heard})", place, is_dropped, question)


def _ways(draft: Draft) -> dict[str, tuple[tuple[str, ...], Place]]:
    """State -> the states that the code goes to from there, with the place of the first way."""
    ways: dict[str, tuple[tuple[str, ...], Place]] = {}
    for source, target, place in draft.transitions:
        targets, first = ways.get(source, ((), place))
        ways[source] = ((*targets, target), first)
    return {state: (tuple(dict.fromkeys(targets)), place) for state, (targets, place) in ways.items()}


def _goes(name: str, draft: Draft, state: str, targets: tuple[str, ...], place: Place) -> list[str]:
    """What the code's own transitions say."""
    told = draft.findings.state
    topic = told.partition(".")[0]
    stays_or_goes = " | ".join(f"{told} == '{target}'" for target in (state, *targets))
    formula = f"always(on({topic}) & last({told}) == '{state}' -> {stays_or_goes})"
    listed = " or ".join(filter(None, (", ".join(targets[:-1]), targets[-1])))
    title = f"From {state} the robot goes to {listed} only"
    lines = _requirement(name, title, formula, str(place), f"goes {state}" in draft.dropped, "where else may it go")
    is_looked_at = any(message.form == "state" for message in draft.findings.said if message.topic == topic)
    return [*lines, *([SKIPPED] if is_looked_at else [])]


def _twice(name: str, draft: Draft, message: Message) -> list[str]:
    """What holds of each robot that does not stutter: it does not say the same twice at one instant."""
    topic = message.topic
    others = "".join(f" | {_differs(f'{topic}.{part.name}', part.kind)}" for part in message.fields if part.kind)
    formula = f"always(on({topic}) -> count[0:0](on({topic})) <= 1{others})"
    title = f"The robot does not say {_words(topic)} twice at once"
    place, is_dropped = str(message.uses[0] if message.uses else message.place), f"twice {topic}" in draft.dropped
    return _requirement(name, title, formula, place, is_dropped, "may it repeat itself")


def _differs(told: str, kind: str) -> str:
    """That a field is not what it was last: only numbers and texts can be compared."""
    return f"last({told}) & !{told} | !last({told}) & {told}" if kind == "bool" else f"last({told}) != {told}"


def _works(name: str, draft: Draft) -> list[str]:
    """What can be asked of a robot that nobody switches off."""
    works = "always(person_is_there -> robot_works)"
    title, is_dropped = "The code works as long as the person is there", "works" in draft.dropped
    return _requirement(name, title, works, draft.findings.package, is_dropped, "may it end before")


def _ends(name: str, draft: Draft) -> list[str]:
    """What can be asked of a robot of which nobody knows what it says."""
    left = "not person_is_there" if draft.ros is not None else "not person_is_there | not robot_works"
    formula = f"always(person_is_there -> eventually[0:900]({left}))"
    return _requirement(name, "A visit ends within 900 s", formula, "TODO: ask for more", False, "")


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
