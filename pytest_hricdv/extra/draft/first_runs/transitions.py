"""What only running shows: transitions that a function of the code computes, called in a process of its own."""

from __future__ import annotations

import ast
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from pytest_hricdv.extra.draft.first_runs import guard
from pytest_hricdv.extra.draft.found.findings import Findings, Place, Transition
from pytest_hricdv.extra.draft.reading.sources import find

LIMIT_S = 20.0
"""So long such a function may take (chosen: it computes a table)."""

_PROGRAM = """
import importlib, json, sys
from pytest_hricdv.extra.draft.first_runs import guard
sys.path.insert(0, sys.argv[1])
pairs = getattr(importlib.import_module(sys.argv[2]), sys.argv[3])()
print(json.dumps([[str(source), str(target)] for source, target in pairs]))
"""


def with_transitions(findings: Findings) -> Findings:
    """The findings, with transitions that a function without parameters returns as pairs of states.

    It is called only where a machine tells states and no transition was read, with effects outside refused.
    """
    machine = next((machine for machine in findings.machines if machine.told), None)
    if machine is None or machine.transitions:
        return findings
    names = {state.name for state in machine.states}
    for module, function, place in _functions(findings):
        pairs = [pair for pair in _called(findings.root, module, function) if set(pair) <= names]
        if pairs:
            moves = tuple(Transition(source, target, place, how="run") for source, target in pairs)
            full = replace(machine, transitions=moves)
            machines = tuple(full if other is machine else other for other in findings.machines)
            questions = tuple(question for question in findings.questions if question.about != "transitions")
            return replace(findings, machines=machines, questions=questions)
    return findings


def _functions(findings: Findings) -> Iterator[tuple[str, str, Place]]:
    """Functions at the top of a module that are called after transitions and take nothing."""
    for scope in find(findings.package, Path(findings.root)).functions:
        node, module = scope.node, scope.module
        if isinstance(node, ast.FunctionDef) and node in module.tree.body and "transition" in node.name:
            arguments = node.args
            if not (arguments.args or arguments.posonlyargs or arguments.kwonlyargs):
                yield module.name, node.name, scope.place


def _called(root: str, module: str, function: str) -> list[tuple[str, str]]:
    with tempfile.TemporaryDirectory(prefix="hri-draft-") as folder:
        notes = str(Path(folder) / "effects.txt")
        environment = {**os.environ, guard.ROOT: root, guard.NOTES: notes, "PYTHONDONTWRITEBYTECODE": "1"}
        command = [sys.executable, "-c", _PROGRAM, root, module, function]
        try:
            done = subprocess.run(
                command, cwd=folder, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                timeout=LIMIT_S,
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            return []
    if done.returncode:
        return []
    return [(source, target) for source, target in json.loads(done.stdout.splitlines()[-1])]
