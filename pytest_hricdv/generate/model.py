"""The BDI model of an interaction, and who plays which part in it."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path

from .error import GenerateError
from .stream import Json, digest

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
        from pytest_hricdv.bdi.language.project_reader import read_project

        try:
            sources = {entry.source for entry in read_project(self.path).agents}
        except (BdiError, OSError) as error:
            raise GenerateError(f"BDI model {self.path}: {error}") from error
        return (self.path, *sorted(sources | set(self.path.parent.rglob("*.asl"))))

    def parts(self) -> list[list[Json]]:
        """All that is declared here, as plain data; of the path only the file's name."""
        declared = {**asdict(self), "path": self.path.name}
        return [[name, declared[name]] for name in sorted(declared)]

    def sha256(self) -> str:
        """Hash (hex) of its files and of what is declared here: models with the same hash behave the same.

        Folders do not count, so that a checkout elsewhere has the same hash.

        Raises:
            GenerateError: a file cannot be read.
        """
        return digest("model", self.parts(), contents(self.files()))


def contents(files: Iterable[Path]) -> list[list[str]]:
    """Name and SHA-256 (hex) of each file, sorted; their folders do not count.

    Raises:
        GenerateError: a file cannot be read.
    """
    found = []
    for path in files:
        try:
            found.append([path.name, hashlib.sha256(path.read_bytes()).hexdigest()])
        except OSError as error:
            raise GenerateError(f"{path}: {error.strerror or error}; expected a readable file") from error
    return sorted(found)
