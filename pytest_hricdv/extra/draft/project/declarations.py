"""Lines of `conftest.py` that drafts of any code share: imports, times, model and beliefs, commands, disturbances."""

from __future__ import annotations

import builtins
import json
import re
from collections.abc import Iterable, Sequence
from keyword import iskeyword

from pytest_hricdv.extra.draft.code.naming import camel
from pytest_hricdv.extra.draft.code_model import OWN_MODULE, Imports
from pytest_hricdv.extra.draft.project.draft import Draft
from pytest_hricdv.extra.draft.project.model import (
    STAY,
    UNTIL_QUIET,
    belief_groups,
    leaves,
    neutral_beliefs,
    start_beliefs,
)
from pytest_hricdv.extra.draft.project.ranges import STAYS, answer_s, limit_s
from pytest_hricdv.runtime.blocking_calls import KINDS


def _is_name(module: str) -> bool:
    """Whether an import statement can name this module."""
    return all(part.isidentifier() and not iskeyword(part) for part in module.split("."))


WIDTH = 88
"""Longer imports have one name per line, as in ruff's default format."""


class ImportTable:
    """The import statements of a file, which already uses the names `taken`."""

    def __init__(self, taken: Iterable[str]) -> None:
        self._taken = {*taken, *dir(builtins)}
        self._names: dict[tuple[str, str], str] = {}

    def use(self, module: str, name: str) -> str:
        """Import a name from a module, and return its local name."""
        key = module, name
        if key not in self._names:
            local = name
            if local in self._taken:
                local = camel(module.rpartition(".")[2]) + name[:1].upper() + name[1:]
            while local in self._taken:
                local += "_"
            self._taken.add(local)
            self._names[key] = local
        return self._names[key]

    def text(self, source: str, imports: Imports) -> str:
        """Source text with its imported names replaced by their local names."""
        for module, name in imports:
            local = self.use(module, name)
            if local != name:
                source = re.sub(rf"(?<![\w.'\"]){re.escape(name)}\b", local, source)
        return source

    def lines(self, indent: str = "    ") -> list[str]:
        """The import statements, sorted; the draft's own module last."""
        by_module: dict[str, list[str]] = {}
        for (module, name), local in self._names.items():
            if not _is_name(module):
                continue
            by_module.setdefault(module, []).append(name if local == name else f"{name} as {local}")
        lines = [f"{indent}{local} = import_module({json.dumps(module)}).{name}"
                 for (module, name), local in self._names.items() if not _is_name(module)]  # fmt: skip
        for module in sorted(by_module, key=lambda module: (module == OWN_MODULE, module)):
            names = sorted(by_module[module])
            lines += import_lines(module, names, indent)
        return lines


def import_lines(module: str, names: Sequence[str], indent: str = "") -> list[str]:
    """The statement that imports names from a module."""
    line = f"{indent}from {module} import {', '.join(names)}"
    if len(line) <= WIDTH:
        return [line]
    return [f"{indent}from {module} import (", *(f"{indent}    {name}," for name in names), f"{indent})"]


def tuple_text(names: Iterable[str], *, quoted: bool = True) -> str:
    """Source text of a tuple of strings, or of names."""
    listed = [json.dumps(name, ensure_ascii=False) if quoted else name for name in names]
    return "(" + ", ".join(listed) + ("," if len(listed) == 1 else "") + ")"


def times_lines(draft: Draft) -> list[str]:
    """The limit of a run, how long a person waits, and the table of when a person acts."""
    late_s, location = draft.late_s
    reason = f"longer than {location}" if location is not None else "TODO: the code has no time-out"
    return [
        "HERE = Path(__file__).parent",
        "",
        f"LIMIT_S = {limit_s(draft):.1f}  # longer than any visit",
        f"ANSWER_S = {answer_s(draft):g}  # how long a person waits for an answer; TODO",
        f"STAYS_S = {STAYS} * ANSWER_S  # a person stays at most this long until the robot is quiet; TODO",
        "",
        "# When and how often a person does something. TODO: what is right for your people?",
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


def command_table_lines(draft: Draft) -> list[str]:
    """The commands for what a person says, and for waiting."""
    waits = ['                "wait_answer": {},']
    if draft.is_alone:
        return [f'                "{STAY}": {{"after_s": Uniform(20.0, 60.0, "s")}},  # TODO: how long?']
    waits += [f'                "{UNTIL_QUIET}": {{}},'] if leaves(draft) else []
    if not draft.inputs:
        return waits
    return [
        "                **{",
        '                    f"{what} {how}": {**times, **say.parameters}',
        "                    for what, say in says.items()",
        "                    for how, times in TIMES.items()",
        "                },",
        *waits,
    ]


def virtual_time_lines(draft: Draft) -> list[str]:
    """The blocking APIs, of libraries too, and the endings allowed besides the person leaving or the code ending."""
    lines = [f"            apis={tuple_text(tuple(KINDS))},"] if draft.ros is None else []
    endings = draft.allowed_endings
    lines += [f"            allowed_endings={tuple_text(endings)},  # TODO: which are right?"] if endings else []
    return ["        time=VirtualTime(", *lines, "        ),"] if lines else []


def state_lines(draft: Draft) -> list[str]:
    """The field in which the robot publishes its state, and its known transitions."""
    if not draft.code.state or draft.has_open_states:
        return []
    moves = [f"                ({json.dumps(a)}, {json.dumps(b)}),  # {at}" for a, b, at in draft.transitions]
    moves = ["            transitions=(", *moves, "            ),"] if moves else []
    return ["        state=StateField(", f'            "{draft.code.state}",', *moves, "        ),"]


def disturbance_lines(draft: Draft) -> list[str]:
    """Disturbances: lost messages, and messages to the robot that come late or twice."""
    lines = []
    for message in draft.messages:
        topic = message.topic
        if message.form in ("called", "service", "action"):
            continue  # a lost request leaves its client without an answer
        if topic != draft.code.state.partition(".")[0]:  # else the robot would seem to skip a state
            lines.append(f'            "{topic}_lost": Drop("{topic}"),')
        if message.direction != "published":
            lines.append(f'            "{topic}_late": Delay("{topic}", Uniform(0.5, 5.0, "s")),  # TODO: how late?')
            if draft.ros is None:
                how = f'Duplicate("{topic}", Uniform(0.1, 5.0, "s")),  # TODO: how late?'
                lines.append(f'            "{topic}_doubled": {how}')
    return ["        disturbances={", *lines, "        },"] if lines else []
