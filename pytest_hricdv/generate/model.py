"""The BDI model of an interaction, and who plays which part in it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from .error import GenerateError

#: Enough for any run that ends by itself, few enough that one that does not is noticed at once.
MAX_ROUNDS = 20_000


@dataclass(frozen=True)
class Model:
    """A multi-agent system that can be steered by beliefs.

    Args:
        path: the project file (.mas2j).
        steering_agent: the agent that hands a chosen subset on.
        chosen: the functor of the percepts, as in `chosen(leg1)`, that tell it the subset.
        actor: the agent whose external actions are the abstract test.
        covered: the agents whose coverage plans count.
        seed: of the model's own random stream.
        max_rounds: reasoning rounds after which a run is ended.

    Raises:
        GenerateError: no covered agent, or no round to run.
    """

    path: Path
    steering_agent: str = "meta"
    chosen: str = "chosen"
    actor: str = "human"
    covered: tuple[str, ...] = ("human", "robot_code")
    seed: int = 0
    max_rounds: int = MAX_ROUNDS

    def __post_init__(self) -> None:
        if not self.covered:
            raise GenerateError(f"{self.path}: no covered agent is named; expected at least one")
        if self.max_rounds < 1:
            raise GenerateError(f"{self.path}: max_rounds = {self.max_rounds}; expected at least 1")

    def files(self) -> tuple[Path, ...]:
        """What its runs can depend on: the project, its agents' sources, every AgentSpeak file below its folder.

        Raises:
            GenerateError: the project cannot be read.
        """
        # Imported here: a session that replays a suite declares its model, but needs no BDI engine.
        from pytest_hricdv.bdi import BdiError
        from pytest_hricdv.bdi.project import read_project

        try:
            sources = {entry.source for entry in read_project(self.path).agents}
        except (BdiError, OSError) as error:
            raise GenerateError(f"BDI model {self.path}: {error}") from error
        return (self.path, *sorted(sources | set(self.path.parent.rglob("*.asl"))))
