"""A toy model that runs are compared with: a robot that hands things over. And runs written as events."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from pytest_hricdv.coupling.percept_mapping import PerceptMapping
from pytest_hricdv.declarations.model_oracle import ActionMapping, ModelOracle
from pytest_hricdv.extra.oracle.conformance_monitor import ConformanceMonitor
from pytest_hricdv.extra.oracle.oracle import load_oracle
from pytest_hricdv.generate.model import Model
from pytest_hricdv.monitor import Value, Verdict, Vocabulary

ROBOT = """
patience(5).
@fetch  +wanted(Thing)[source(person)] <- -wanted(Thing)[source(person)]; take(Thing); !offer.
-!offer <- put_back.
@offer  +!offer : patience(Limit)
   <- .send(person, tell, offered);
      .wait(thanks[source(person)], Limit);
      .abolish(thanks);
      let_go.
"""
VOCABULARY = Vocabulary(
    messages={
        "order": {"thing": str},
        "taken": {"thing": str},
        "offer": {},
        "thank": {},
        "state": {"name": str},
        "put_back": {},
        "report": {"count": float},
    },
    signals={"holding": bool, "gripping": bool, "weight": float},
)
TOY = ModelOracle(
    agent="robot",
    percepts=(
        PerceptMapping("wanted(Thing)", "on(order)", source="person"),
        PerceptMapping("thanks", "on(thank)", source="person"),
    ),
    actions=(
        ActionMapping("take(Thing)", "on(taken)", within_s=(1.0, 10.0)),
        ActionMapping("offered", "on(offer)", within_s=(0.0, 2.0)),
        ActionMapping("let_go", "fall(holding)", within_s=(0.0, 1.0)),
        ActionMapping("put_back", "on(put_back)", within_s=(0.0, 2.0)),
    ),
    limits={"patience": "patience_s"},
    tolerance_s=0.5,
)
RUN = {"patience_s": 5.0}

Event = tuple[float, str] | tuple[float, str, object]
"""Time (s) and signal with its value; or time, topic, and its fields if it has any."""

HANDED_OVER: tuple[Event, ...] = (
    (0.0, "holding", False),
    (1.0, "order", {"thing": "cup"}),
    (4.0, "holding", True),
    (4.0, "taken", {"thing": "cup"}),
    (5.0, "offer"),
    (7.0, "thank"),
    (7.5, "holding", False),
)


def model(folder: Path, robot: str = ROBOT) -> Model:
    """The model, written to a folder."""
    (folder / "toy.mas2j").write_text("MAS toy { agents: person; robot; }", encoding="utf-8")
    (folder / "person.asl").write_text("", encoding="utf-8")
    (folder / "robot.asl").write_text(robot, encoding="utf-8")
    return Model(folder / "toy.mas2j", covered=("robot",))


class Toy:
    """Follows runs with the robot of a model.

    Args:
        folder: for the model.
        robot: its source.
        changes: of the declaration.
    """

    def __init__(self, folder: Path, robot: str = ROBOT, **changes: Any) -> None:
        self.declaration = replace(TOY, **changes)
        self.oracle = load_oracle(self.declaration, model(folder, robot), VOCABULARY, RUN)

    def follow(self, *events: Event, end_s: float = 60.0, run: Mapping[str, float] = RUN) -> Verdict:
        """The verdict on a run."""
        monitor = ConformanceMonitor(self.oracle, run)
        for time_s, name, *rest in events:
            value = rest[0] if rest else {}
            if isinstance(value, dict):
                monitor.message(time_s, name, value)
            else:
                assert isinstance(value, bool | float)
                monitor.signal(time_s, name, value)
        return monitor.finish(end_s)


def violation(verdict: Verdict) -> str:
    """When a run deviated (s), and how."""
    [found] = verdict.violations
    return f"{found.time_s:g} s: {found.text}"


def without(topic: str, events: tuple[Event, ...] = HANDED_OVER) -> tuple[Event, ...]:
    """A run without the events of a topic."""
    return tuple(event for event in events if event[1] != topic)


def moved(name: str, time_s: float, events: tuple[Event, ...] = HANDED_OVER) -> tuple[Event, ...]:
    """A run with the last event of a topic or signal at another time (s)."""
    index = max(number for number, event in enumerate(events) if event[1] == name)
    changed = [*events[:index], (time_s, *events[index][1:]), *events[index + 1 :]]
    return tuple(sorted(changed, key=lambda event: event[0]))


__all__ = ["HANDED_OVER", "ROBOT", "RUN", "TOY", "VOCABULARY", "Toy", "Value", "model", "moved", "violation", "without"]
