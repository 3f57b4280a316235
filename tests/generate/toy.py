"""A small interaction that is not the table: a visitor asks a guide to switch lamps. And a runner without a model."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

from pytest_hricdv.generate.beliefs import BeliefSpace
from pytest_hricdv.generate.model import Model, ModelRun

LAMPS = BeliefSpace(
    start=("hall", "cellar"),
    groups={"mood": ("polite", "curt"), "wish": ("bright", "dim", "dark")},
    id_groups=("mood",),
)

PROJECT = """
MAS lamps { agents: usher; visitor; guide; }
"""
USHER = """
+chosen(B) <- .send(visitor, tell, B).
"""
VISITOR = """
@v1 +hall <- enter(hall); !wish.
@v2 +cellar <- enter(cellar); !wish.
@v3 +!wish : polite & bright <- greet; set_lamp(level, 100); .send(guide, tell, asked).
@v4 +!wish : polite <- greet; set_lamp(level, 10).
@v5 +!wish : curt & dark <- set_lamp(level, 0); .send(guide, tell, asked).
@v6 +!wish : dim <- set_lamp(level, 10).
@v7 +!wish <- leave.
"""
GUIDE = """
@g1 +asked <- !serve.
@g2 +!serve <- switch.
"""


def lamps(folder: Path, *, visitor: str = VISITOR, guide: str = GUIDE) -> Model:
    """The model, written to a folder."""
    files = {"lamps.mas2j": PROJECT, "usher.asl": USHER, "visitor.asl": visitor, "guide.asl": guide}
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    return Model(
        folder / "lamps.mas2j", steering_agent="usher", actor="visitor", covered=("visitor", "guide"), max_rounds=500
    )


class FakeRunner:
    """A model runner without a model: the plans are a function of the subset, given by the test."""

    def __init__(self, plans: Callable[[frozenset[str]], dict[str, set[str]]]) -> None:
        self.plans = plans
        self.asked: list[tuple[str, ...]] = []

    def run(self, beliefs: Iterable[str]) -> ModelRun:
        subset = tuple(beliefs)
        self.asked.append(subset)
        plans = {agent: frozenset(labels) for agent, labels in self.plans(frozenset(subset)).items()}
        return ModelRun(subset, ("wave",), plans)
