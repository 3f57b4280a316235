"""Writes the `requirements.toml` of a draft, with requirements such as that each message is answered.

Those that fail in the first runs become comments with questions.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

from pytest_hricdv.extra.draft.code.attributes import ATTRIBUTE, OBSERVED
from pytest_hricdv.extra.draft.code_model import Message
from pytest_hricdv.extra.draft.project.draft import Draft
from pytest_hricdv.extra.draft.project.ranges import limit_s
from pytest_hricdv.monitor.requirement import FormulaSource, RequirementError
from pytest_hricdv.monitor.syntax_tree import syntax_tree

ANSWER_S = 60.0
"""Time limit (s) for the robot's answer: a person who waits for longer has left."""

ENDS_VISIT = "ends"
"""Subject of the requirement that a visit ends, which a draft has if there is no other."""

HEAD = """\
# always(a -> b) is checked whenever a holds; if it never holds in a test, the verdict is NC, not checked.
# These are a draft: they held in the first runs, and nobody has asked for them yet.
# That no exception ends the code is checked in each run, without a requirement.
"""


@dataclass(frozen=True)
class DraftedRequirement:
    """A requirement; if first runs violate it, `Draft.dropped` has its subject, and its question is asked."""

    subject: str
    title: str
    formula: str
    location: str
    question: str


def requirement_ids(draft: Draft) -> dict[str, str]:
    """Subject of each requirement -> its id."""
    return {requirement.subject: f"R{number}" for number, requirement in enumerate(_requirements(draft), 1)}


def requirements(draft: Draft) -> str:
    """The file of requirements; a requirement that did not hold in the first runs is a comment, with a question."""
    parts = [HEAD]
    for number, requirement in enumerate(_requirements(draft), 1):
        lines = [
            f"[R{number}]",
            f"title = {json.dumps(requirement.title, ensure_ascii=False)}",
            f"formula = {json.dumps(requirement.formula, ensure_ascii=False)}",
        ]
        if requirement.subject in draft.dropped:
            question = f"# TODO: {requirement.question}? In the first runs this did not hold, or was not seen."
            lines = [question, *(f"# {line}" for line in lines)]
        parts.append("\n".join(["", f"# {requirement.location}", *lines, ""]))
    return "".join(parts)


def _requirements(draft: Draft) -> Iterator[DraftedRequirement]:
    """The requirements that the language can express."""
    return (requirement for requirement in _candidates(draft) if _is_expressible(requirement.formula))


def _candidates(draft: Draft) -> Iterator[DraftedRequirement]:
    yield from _answers(draft)
    if draft.code.outputs:
        yield _cause(draft) if draft.inputs else _sign_of_life(draft)
    yield from _transitions(draft)
    for message in draft.code.outputs:
        yield _repetition(message)
    if draft.tells_presence:
        yield from _presence(draft)


def _answers(draft: Draft) -> Iterator[DraftedRequirement]:
    """Require that the robot answers what it receives; each text of a message has its own requirement."""
    answers = " | ".join(f"on({message.topic})" for message in draft.answers)
    for thing in draft.inputs if draft.answers else ():
        topic, location = thing.message.topic, thing.message.uses[0]
        part = next((part for part in thing.message.fields if part.kind == "str" and len(part.values) > 1), None)
        cases = [(_words(topic), f"on({topic})", location)]
        if part is not None:
            cases = [(f"{_words(topic)} {value.text}", f"on({topic}) & {topic}.{part.name} == {_quote(value.text)}",
                      value.location) for value in part.values]  # fmt: skip
        for words, condition, at in cases:
            yield DraftedRequirement(
                f"answer {words}",
                f"The robot publishes something within {ANSWER_S:g} s after {words}",
                f"always({condition} -> eventually[0:{ANSWER_S:g}]({answers}))",
                str(at),
                "is it to be answered",
            )


def _cause(draft: Draft) -> DraftedRequirement:
    """A requirement for robots that publish only on request."""
    message = draft.answers[0]
    received = " | ".join(f"on({thing.message.topic})" for thing in draft.inputs)
    return DraftedRequirement(
        "cause",
        f"Before {_words(message.topic)}, the robot has received something",
        f"always(on({message.topic}) -> once({received}))",
        str(message.location),
        "may it come of itself",
    )


def _sign_of_life(draft: Draft) -> DraftedRequirement:
    """A requirement for robots that act without being told anything."""
    answers = " | ".join(f"on({message.topic})" for message in draft.answers)
    return DraftedRequirement(
        "sign of life",
        f"While a person is there, the robot publishes something every {ANSWER_S:g} s",
        f"always(person_is_there -> eventually[0:{ANSWER_S:g}]({answers} | not person_is_there))",
        str(draft.answers[0].location),
        "may it be silent for longer",
    )


def _transitions(draft: Draft) -> Iterator[DraftedRequirement]:
    """Require that the robot changes its state only as its code declares."""
    state = draft.code.state
    topic = state.partition(".")[0]
    is_declared = draft.code.machine is not None and draft.code.machine.kind not in (ATTRIBUTE, OBSERVED)
    for source in dict.fromkeys(source for source, _, _ in draft.transitions) if is_declared else ():
        moves = [(target, location) for origin, target, location in draft.transitions if origin == source]
        targets = list(dict.fromkeys(target for target, _ in moves))
        allowed = " | ".join(f"{state} == {_quote(target)}" for target in (source, *targets))
        listed = " or ".join(filter(None, (", ".join(targets[:-1]), targets[-1])))
        yield DraftedRequirement(
            f"transitions of {source}",
            f"From {source} the robot goes to {listed} only",
            f"always(on({topic}) & last({state}) == {_quote(source)} -> {allowed})",
            str(moves[0][1]),
            "where else may it go",
        )


def _repetition(message: Message) -> DraftedRequirement:
    """A requirement for robots that do not publish the same message twice at one instant."""
    topic = message.topic
    differs = "".join(f" | {_differs(f'{topic}.{part.name}', part.kind)}" for part in message.fields if part.kind)
    return DraftedRequirement(
        f"repetition of {topic}",
        f"The robot does not publish {_words(topic)} twice at one instant",
        f"always(on({topic}) -> count[0:0](on({topic})) <= 1{differs})",
        str(message.uses[0] if message.uses else message.location),
        "may it repeat itself",
    )


def _differs(field: str, kind: str) -> str:
    """A condition that a field has changed; only numbers and strings can be compared."""
    return f"last({field}) & !{field} | !last({field}) & {field}" if kind == "bool" else f"last({field}) != {field}"


def _presence(draft: Draft) -> Iterator[DraftedRequirement]:
    """A requirement for robots whose messages are unknown."""
    # If the first runs refuted all requirements, it is unknown whether the code may end before the person leaves.
    if draft.ros is None and not draft.has_dropped_all:
        yield DraftedRequirement(
            "works",
            "The code works as long as the person is there",
            "always(person_is_there -> robot_works)",
            draft.code.package,
            "may it end before",
        )
    left = "not person_is_there" if draft.ros is not None else "not person_is_there | not robot_works"
    longest = f"{limit_s(draft):g}"
    formula = f"always(person_is_there -> eventually[0:{longest}]({left}))"
    title = f"A visit ends within {longest} s"
    yield DraftedRequirement(ENDS_VISIT, title, formula, "TODO: ask for more", "may it be longer")


def _words(topic: str) -> str:
    return topic.replace("_", " ")


@cache
def _is_expressible(formula: str) -> bool:
    """Whether the language can say it: it has no escapes in texts, and names of ASCII only."""
    try:
        syntax_tree(FormulaSource(formula), "formula")
    except RequirementError:
        return False
    return True


def _quote(text: str) -> str:
    """A text in a formula."""
    return f'"{text}"' if "'" in text else f"'{text}'"
