"""A toy model whose person lives in made-up runs: somebody who fetches cups, as often as they are offered one."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pytest_hricdv.coupling.percept_mapping import PerceptMapping
from pytest_hricdv.generate.beliefs import BeliefSpace
from pytest_hricdv.generate.model import Model
from pytest_hricdv.monitor import Value, Vocabulary
from pytest_hricdv.online.decisions import NONE, ChoicePoint
from pytest_hricdv.online.declaration import InteractiveAgent
from pytest_hricdv.online.online_agent import OnlineAgent
from pytest_hricdv.online.role import Role, load_role

META = """
!steer.
+!steer <- for (chosen(B)) { .send(person, tell, B) }; .send(person, achieve, fetch).
"""
PERSON = """
@thirsty +!fetch : thirsty <- press; .send(robot, tell, wanted).
@curious +!fetch : curious <- wave; .send(robot, tell, wanted).

@hot     +cup(Size) : likes_hot  <- -cup(Size)[source(robot)]; drink(hot); !thank.
@cold    +cup(Size) : likes_cold <- -cup(Size)[source(robot)]; cool; drink(Size); !thank.
@refuse  +cup(Size) <- -cup(Size)[source(robot)]; refuse.

@thank   +!thank : loud <- shout.
+!thank  <- nod.
@alarm   +alarm <- leave.
"""
VOCABULARY = Vocabulary(messages={"offer": {"size": str}, "state": {"name": str}}, signals={"smoke": bool})
HEARS = (
    PerceptMapping("cup(Size)", "on(offer)", source="robot"),
    PerceptMapping("alarm", "rise(smoke)"),
)
SPACE = BeliefSpace(
    start=("thirsty", "curious"),
    groups={"taste": ("likes_hot", "likes_cold"), "voice": ("loud", "quiet")},
    default_beliefs=("quiet",),
)


def model(folder: Path, person: str = PERSON) -> Model:
    """The model, written to a folder."""
    (folder / "toy.mas2j").write_text("MAS toy { agents: meta; person; robot; }", encoding="utf-8")
    for name, text in {"meta": META, "person": person, "robot": ""}.items():
        (folder / f"{name}.asl").write_text(text, encoding="utf-8")
    return Model(folder / "toy.mas2j", actor="person", covered=("person",))


def role(
    folder: Path, person: str = PERSON, declaration: InteractiveAgent | None = None, disturbances: Sequence[str] = ()
) -> Role:
    """The role of the person; another person need not care for what it hears."""
    person += "" if person == PERSON else " +cup(_). +alarm."
    declaration = declaration or InteractiveAgent("person", HEARS)
    return load_role(declaration, model(folder, person), SPACE, VOCABULARY, disturbances, "state.name", [planned])


def planned(commands: Sequence[str]) -> list[Any]:
    """An interaction begins with a request."""
    return [command for command in commands if command in ("press", "wave")]


class Wish:
    """Chooses what was wished: what is decided -> the options, one time after the other; the last one again and again.

    Else the first start belief, no belief, no goal, and the first act.
    """

    def __init__(self, **wishes: Sequence[str]) -> None:
        self._wishes = {about: [*options] for about, options in wishes.items()}
        self.asked: list[ChoicePoint] = []

    def choose(self, decision: ChoicePoint) -> str:
        """See `Chooser`."""
        self.asked.append(decision)
        wishes = self._wishes.get(decision.about)
        if wishes:
            return wishes.pop(0) if len(wishes) > 1 else wishes[0]
        return NONE if NONE in decision.options else decision.options[0]


class Life:
    """The person in a made-up run: one second passes with each command.

    Args:
        role: of the person.
        chooser: decides.
    """

    def __init__(self, role: Role, chooser: Wish) -> None:
        self.chooser = chooser
        self.agent = OnlineAgent(role, chooser)
        self.time_s = 0.0

    def said(self, topic: str, **fields: Value) -> None:
        """A message arrives now."""
        self.agent.message(self.time_s, topic, fields)

    def commands(self, most: int = 100) -> list[str]:
        """What the person does, up to when there is nothing to do."""
        done: list[str] = []
        while len(done) < most and (command := self.agent.next_command(self.time_s)) is not None:
            done.append(command)
            self.time_s += 1.0
        return done
