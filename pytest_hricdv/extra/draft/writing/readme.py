"""The README of a draft: what to edit next, ranked by what it would bring."""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv.extra.draft.found.nodes import ros_lines
from pytest_hricdv.extra.draft.writing.drafted import Draft

MOST = 10
"""Lines to edit that are listed."""


def readme(draft: Draft) -> str:
    """The README."""
    findings = draft.findings
    lines = [
        f"# Tests of {draft.robot}, drafted",
        "",
        f"`python -m pytest_hricdv init {_asked(draft)}` read the code and wrote this folder. Nothing in",
        "it is required of the robot yet; it runs, and each value has the place that it comes from.",
        "",
        "```sh",
        "pytest                       # the learned suite",
        "pytest --hri-suite=closure   # a small one that reaches what can be reached",
        "```",
        "",
        "## What was found",
        "",
        "| what | how many | |",
        "|---|---|---|",
        f"| messages that it hears | {len(findings.heard)} | {', '.join(m.name for m in findings.heard)} |",
        f"| messages that it says | {len(findings.said)} | {', '.join(m.name for m in findings.said)} |",
        f"| states | {len(draft.states)} | {', '.join(draft.states)} |",
        f"| transitions | {len(draft.transitions)} | |",
        f"| calls that wait | {len(findings.waits)} | virtual: {', '.join(findings.virtual) or 'none'} |",
        f"| numbers with units | {len(findings.constants)} | |",
        "",
        *_nodes(draft),
        "## The next lines to edit",
        "",
        "The first ones bring most.",
        "",
    ]
    edits = list(dict.fromkeys(_edits(draft)))[:MOST]
    lines += [f"{number}. {edit}" for number, edit in enumerate(edits, 1)]
    if findings.problems:
        lines += ["", "## What was in the way", ""]
        lines += [f"- {f'`{p.place}`: ' if p.place is not None else ''}{p.text}" for p in findings.problems]
    questions = findings.questions
    if questions:
        lines += ["", "## All questions", ""]
        lines += [f"- {f'`{q.place}`: ' if q.place is not None else ''}{q.text}" for q in questions]
    return "\n".join(lines) + "\n"


def _asked(draft: Draft) -> str:
    if draft.ros is None:
        return f"--from {draft.findings.package}"
    return f"--launch {draft.ros.asked}" if draft.ros.nodes else f'--ros2 "{draft.ros.asked}"'


def _nodes(draft: Draft) -> list[str]:
    """What nodes of ROS 2 say and hear."""
    nodes = draft.findings.ros
    if not nodes.nodes and not nodes.endpoints:
        return []
    return ["## Nodes of ROS 2", "", *(f"- {line}" for line in ros_lines(nodes)), ""]


def _edits(draft: Draft) -> Iterator[str]:
    """What to edit, the most useful first: what is asked of the robot, then who acts, then the world, then numbers."""
    first = next((q for q in draft.findings.questions if q.about in ("entry", "messages")), None)
    if first is not None:
        yield f"`conftest.py`, `run`: {first.text}."
    yield "`requirements.toml`: write what is required of the robot, one `[R...]` with a title and a formula."
    for subject in draft.dropped[:2]:
        yield f"`requirements.toml`: *{subject}* did not hold in the first runs, and is a comment: is it to hold?"
    if draft.sensors:
        sensor = draft.sensors[0]
        yield f"`world.py`, `SENSES`: what does `{sensor.name}` say, and when? (`{sensor.operation.place}`)"
    yield f"`models/{draft.person}.asl`: what do people do with this robot, and in which order?"
    yield "`conftest.py`, `TIMES`: how early and how late is too early and too late for your people?"
    for port in draft.devices[:2]:
        yield f"`ports.py`, `{port.name}`: what does it do in the world? (`{port.place}`)"
    for port in draft.parameters[:2]:
        yield f"`conftest.py`, `run={{...}}`: between which values is `{port.name}`? (`{port.place}`)"
    for thing in draft.things:
        for part in thing.numbers[:1]:
            yield f"`conftest.py`, `SAYS`: how large is `{part.name}` of {thing.message.name}? (`{part.place}`)"
    if draft.states:
        yield "`models/robot.asl`: through which states does the robot go for what it hears?"
    if draft.may_end:
        yield "`conftest.py`, `may_end`: which ends of a run are right?"
