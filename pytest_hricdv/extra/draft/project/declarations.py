"""Declarations common to all drafted testbenches: times, the model with its beliefs, and commands."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence

from pytest_hricdv.extra.draft.project.draft import Draft
from pytest_hricdv.extra.draft.project.model import (
    STAY,
    UNTIL_QUIET,
    belief_groups,
    leaves,
    neutral_beliefs,
    start_beliefs,
)
from pytest_hricdv.extra.draft.project.ranges import times_of_lines


def tuple_text(names: Iterable[str], *, quoted: bool = True) -> str:
    """Source text of a tuple of texts, or of names."""
    listed = [json.dumps(name, ensure_ascii=False) if quoted else name for name in names]
    return "(" + ", ".join(listed) + ("," if len(listed) == 1 else "") + ")"


def times_lines(late_s: float, reason: str) -> list[str]:
    """The table of how a person does something."""
    return [
        "",
        "# When a person does something, and how often. TODO: what is right for your people?",
        "TIMES = {",
        '    "in_time": {"after_s": Uniform(0.5, 2.0, "s")},',
        '    "too_early": {"after_s": Uniform(0.0, 0.05, "s")},',
        f'    "too_late": {{"after_s": Uniform({late_s * 1.1:g}, {late_s * 1.5:g}, "s")}},  # {reason}',
        '    "twice": {"after_s": Uniform(0.5, 2.0, "s"), "again_s": Uniform(0.1, 1.0, "s")},',
        "}",
    ]


def model_lines(draft: Draft) -> list[str]:
    """The lines of a testbench down to its commands: name, model, beliefs."""
    covered = f'"{draft.person}", "robot"' if draft.inputs else f'"{draft.person}",'
    return [
        "    return Testbench(",
        f'        name="{draft.robot}",',
        "        model=Model(",
        f'            HERE / "models" / "{draft.robot}.mas2j",',
        f'            actor="{draft.person}",',
        f"            covered=({covered}),",
        "        ),",
        "        beliefs=BeliefSpace(",
        f"            start={tuple_text(start_beliefs(draft))},",
        "            groups={",
        *(f"                {json.dumps(name)}: {tuple_text(beliefs)},"
          for name, beliefs in belief_groups(draft).items()),
        "            },",
        *([f"            default_beliefs={tuple_text(neutral_beliefs(draft))},"] if neutral_beliefs(draft) else []),
        "        ),",
        "        concretization=Concretization(",
        "            commands={",
    ]  # fmt: skip


def command_table_lines(draft: Draft, table: str, numbers: str, each: str) -> list[str]:
    """The commands of what a person says, and of waiting.

    Args:
        draft: the draft.
        table: name of the table of what is said.
        numbers: expression of the numbers of one entry of it.
        each: name of the entry in this expression.
    """
    waits = ['                "wait_answer": {},']
    if draft.is_alone:
        return [f'                "{STAY}": {{"after_s": Uniform(20.0, 60.0, "s")}},  # TODO: how long?']
    waits += [f'                "{UNTIL_QUIET}": {{}},'] if leaves(draft) else []
    if not draft.inputs:
        return waits
    others = "**TIMES_OF.get(what, {}).get(how, {}), " if times_of_lines(draft) else ""
    return [
        "                **{",
        f'                    f"{{what}} {{how}}": {{**times, {others}**{numbers}}}',
        f"                    for what, {each} in {table}.items()",
        "                    for how, times in TIMES.items()",
        "                },",
        *waits,
    ]


def time_lines(draft: Draft, apis: Sequence[str] = ()) -> list[str]:
    """The blocking APIs that the code uses, and how runs may end without the person leaving or the robot returning."""
    lines = [f"            apis={tuple_text(apis)},  # the code imports them"] if apis else []
    endings = draft.allowed_endings
    lines += [f"            allowed_endings={tuple_text(endings)},  # TODO: which ends are right?"] if endings else []
    return ["        time=VirtualTime(", *lines, "        ),"] if lines else []


def state_lines(draft: Draft) -> list[str]:
    """The field in which the robot publishes its state, and the transitions that are known."""
    if not draft.code.state or draft.has_open_states:
        return []
    moves = [f"                ({json.dumps(a)}, {json.dumps(b)}),  # {at}" for a, b, at in draft.transitions]
    moves = ["            transitions=(", *moves, "            ),"] if moves else []
    return ["        state=StateField(", f'            "{draft.code.state}",', *moves, "        ),"]
