"""Small multi-agent systems written into a test's folder, and the table model with chosen beliefs."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path

from pytest_hricdv.bdi import Environment, MultiAgentSystem, Result

TABLE = Path(__file__).parents[2] / "models_bdi" / "table_assembly.mas2j"
LEG_STARTS = ("leg1", "leg2", "leg3", "leg4")
POSES = tuple(f"m{pose:03b}l{leg}" for leg in range(1, 5) for pose in range(8))
BELIEFS = (*LEG_STARTS, "bored", "not_bored", *POSES)


def system_of(folder: Path, environment: Environment | None = None, /, **sources: str) -> MultiAgentSystem:
    """A system of one agent for each keyword, whose value is its source."""
    for name, source in sources.items():
        (folder / f"{name}.asl").write_text(source, encoding="utf-8")
    agents = " ".join(f"{name};" for name in sources)
    (folder / "mas.mas2j").write_text(f"MAS test {{ agents: {agents} }}", encoding="utf-8")
    return MultiAgentSystem.load(folder / "mas.mas2j", environment)


def prints_of(folder: Path, source: str) -> list[str]:
    """What a single agent ``a`` prints, without its name."""
    return [line.removeprefix("[a] ") for line in system_of(folder, a=source).run(max_rounds=5000).prints]


@lru_cache(maxsize=1)
def table() -> MultiAgentSystem:
    """The model of the table assembly."""
    return MultiAgentSystem.load(TABLE)


def run_table(beliefs: Iterable[str], max_rounds: int = 1500) -> Result:
    """A run of the table model with these beliefs chosen for the human."""
    return table().run(max_rounds=max_rounds, percepts={"meta": [f"chosen({belief})" for belief in beliefs]})


def abstract_test(result: Result) -> list[str]:
    """The human's actions in the text form of abstract tests."""
    return [_line(text) for agent, text in result.actions if agent == "human"]


def _line(action: str) -> str:
    parameter = re.fullmatch(r"set_param\((\w+),(\d)\)", action)
    if parameter:
        return f"set_param {parameter[1]} = {parameter[2]}"
    spoken = re.fullmatch(r"tell\((\w+)\)", action)
    return f"tell {spoken[1]}" if spoken else action


def labels(result: Result, agent: str) -> list[str]:
    """The labelled plans an agent executed, in order."""
    return [label for label in result.plans[agent] if not label.startswith("_")]
