"""Attacks on the tool: code, files and options that a user might have, each with what has to be seen.

Each `KIND.toml` is a kind; a table in it is an attack on the project that `hricdv init arm --robot=arm` writes, or, for
models and drafts, on an empty folder. `Attack` names its keys. Attacks are written without a look at how the code
handles them.
"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, field, fields
from pathlib import Path
from textwrap import indent
from typing import Any

FOLDER = Path(__file__).parent

LIMIT_S = 150.0
"""Of an attack, in real time, for each of its commands: its aim is a minute on a machine that does nothing else."""

STATUSES = {"passed": {0}, "failed": {1}, "refused": {2, 4}, "loud": set(range(1, 256)), "any": set(range(128))}
"""How the last command of an attack may end -> its exit statuses."""

OURS = re.compile(
    r'Traceback \(most recent call last\):\n(?:[^\n]*\n)*?  File "[^"]*/pytest_hricdv/[^\n]*\n[^\n]*\n(?=\w)'
)
"""A traceback whose last frame is in the package."""


@dataclass(frozen=True)
class Attack:
    """An attack.

    Args:
        kind: the name of its file.
        name: of its table.
        ends: how its last command ends, a key of `STATUSES`.
        sees: patterns of which each has to be in the output; where it is `either`, only if it does not pass.
        never: patterns that must not be there.
        either: whether it may also pass.
        has: keys of report.json that must not be empty.
        report: whether there has to be a report.
        commands: for bash, one after the other; the last one is judged.
        top: added to the robot's module.
        asked: what the robot does first when a person has asked.
        test: the host test.
        asl: the agent's source.
        robot: the source of a package for a draft.
        edits: file, old and new text.
        files: further files, path -> text.
    """

    kind: str
    name: str
    ends: str = "passed"
    sees: tuple[str, ...] = ()
    never: tuple[str, ...] = ()
    either: bool = False
    has: tuple[str, ...] = ()
    report: bool = True
    commands: tuple[str, ...] = ()
    top: str = ""
    asked: str = ""
    test: str = ""
    asl: str = ""
    robot: str = ""
    edits: tuple[tuple[str, str, str], ...] = ()
    files: dict[str, str] = field(default_factory=dict)

    @property
    def is_project(self) -> bool:
        """Whether it begins with a project."""
        return self.kind not in ("models", "drafts")

    def script(self) -> tuple[str, ...]:
        """Its commands."""
        default = {"models": "hricdv model run m.mas2j", "drafts": "hricdv init hri --from robot --budget 3"}
        return self.commands or (default.get(self.kind, "pytest -q --hri-tests=2"),)

    def write(self, folder: Path) -> None:
        """Write its files to a folder, over those of the project there."""
        if self.kind == "models":
            _write(folder / "m.mas2j", "MAS m { agents: a; }")
        for name, text in (("a.asl", self.asl), ("robot.py", self.robot), ("test_arm.py", self.test)):
            if text:
                _write(folder / name, text)
        waits = "    while requests.wait(patience_s) is not None:\n"
        edits = [
            ("arm.py", "WORK_S,", f"{self.top}\nWORK_S,"),
            ("arm.py", waits, waits + indent(self.asked, " " * 8) + "\n"),
        ]
        for name, old, new in (*(edits if self.is_project else ()), *self.edits):
            text = (folder / name).read_text(encoding="utf-8")
            if old not in text:
                raise ValueError(f"{self.kind}.{self.name}: not in {name}: {old}")
            _write(folder / name, text.replace(old, new))
        for name, text in self.files.items():
            _write(folder / name, text)


def attacks(folder: Path = FOLDER) -> Iterator[Attack]:
    """All of them, in the order of their files."""
    known = {each.name for each in fields(Attack)}
    for path in sorted(folder.glob("*.toml")):
        for name, row in tomllib.loads(path.read_text(encoding="utf-8")).items():
            if unknown := set(row) - known:
                raise ValueError(f"{path.stem}.{name}: {', '.join(sorted(unknown))}")
            yield Attack(path.stem, name, **_values(row))


def _values(row: dict[str, Any]) -> dict[str, Any]:
    return {key: tuple(value) if isinstance(value, list) else value for key, value in row.items()}


def judge(attack: Attack, folder: Path, output: str, statuses: list[int]) -> str:
    """What is wrong with how an attack ended; empty where nothing is."""
    status = statuses[-1]
    if "INTERNALERROR" in output:
        return "INTERNALERROR"
    if OURS.search(output) or ("hricdv " in attack.script()[-1] and "Traceback (most recent call last)" in output):
        return "a traceback of the tool"
    if -9 in statuses and "END=" not in "".join(attack.script()):
        return f"did not end in {LIMIT_S:.0f} s"
    status = status if status >= 0 else 128 - status  # ended by a signal
    passed = attack.either and status == 0
    if not passed and status not in (STATUSES["loud" if attack.either else attack.ends]):
        return f"status {status}"
    if missing := [each for each in attack.sees if not passed and not re.search(each, output)]:
        return f"not seen: {missing[0]}"
    if seen := [each for each in attack.never if re.search(each, output)]:
        return f"seen: {seen[0]}"
    return "" if status == 4 else _wrong_report(attack, folder)


def _wrong_report(attack: Attack, folder: Path) -> str:
    if not (attack.is_project and attack.report):
        return ""
    path = folder / "hri-report" / "report.json"
    if not path.exists():
        return "no report"
    report = json.loads(path.read_text(encoding="utf-8"))
    return next((f"no {key} in the report" for key in attack.has if not report.get(key)), "")


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
