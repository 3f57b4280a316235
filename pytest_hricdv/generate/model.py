"""`Model`, the BDI model that a testbench declares; `ModelRun`, one run of it; `Exploration`, all its runs.

`ModelRunner` makes a `ModelRun` for each belief set. `coverage.reachability` keeps an `Exploration` in pytest's cache.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple

from pytest_hricdv._base.input_file import MalformedError, read_bytes, read_text
from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.abstract import Plans
from pytest_hricdv.generate.rng import Json, digest

MAX_ROUNDS = 20_000
"""Default of `Model.max_rounds`, enough for any run that ends by itself: of 4,000 runs of the case study's model with
random beliefs, the longest takes 346 rounds."""

_COVERED = ("human", "robot_code")

EXPLORATION_SCHEMA = "hricdv-exploration/1"
_FIRST_CODE = ord("0")
"""In the cache, each command is one character, numbered from this one on; so none is a comma or a line break."""


_NAME = re.compile(r"[a-z]\w*\Z", re.ASCII)  # it begins lines of tests: `nurse: press call`


@dataclass(frozen=True)
class Model:
    """A multi-agent system that can be steered by beliefs.

    Args:
        path: the project file (.mas2j).
        steering_agent: the agent that passes a chosen subset on.
        chosen: the functor of the percepts, as in `chosen(leg1)`, by which it receives the subset.
        actor: the agent whose external actions are the abstract test.
        actors: the agents whose external actions are the abstract test, where there are several: each is a lane of it,
            and `actor` is ignored.
        covered: the agents whose coverage plans count; by default, the actors and `robot_code`.
        seed: the seed of the model's own random stream.
        max_rounds: reasoning rounds after which a run is ended.

    Raises:
        GenerateError: no covered agent, no round to run, or actors that are not names.
    """

    path: Path
    steering_agent: str = "meta"
    chosen: str = "chosen"
    actor: str = "human"
    covered: tuple[str, ...] = _COVERED
    seed: int = 0
    max_rounds: int = MAX_ROUNDS
    actors: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        self._take_actors()
        if not self.covered:
            raise GenerateError(f"{self.path}: no covered agent is named; expected at least one")
        if self.max_rounds < 1:
            raise GenerateError(f"{self.path}: max_rounds = {self.max_rounds}; expected at least 1")

    def _take_actors(self) -> None:
        """Check the actors; of one, it is as if `actor` named it: a test with one actor does not say who acts."""
        if isinstance(self.actors, str) or not all(_NAME.match(name) for name in self.actors):
            raise GenerateError(f"{self.path}: actors = {self.actors!r}; expected names of agents: actors=('a', 'b')")
        if len(set(self.actors)) < len(self.actors):
            raise GenerateError(f"{self.path}: actors = {self.actors!r}; expected each once")
        # A frozen dataclass has no other way to set a field.
        if self.actors and self.covered == _COVERED:
            object.__setattr__(self, "covered", (*self.actors, _COVERED[1]))
        if len(self.actors) == 1:
            object.__setattr__(self, "actor", self.actors[0])
        object.__setattr__(self, "actors", tuple(self.actors) if len(self.actors) > 1 else ())

    @property
    def who_acts(self) -> tuple[str, ...]:
        """The actors, at least one."""
        return self.actors or (self.actor,)

    def files(self) -> tuple[Path, ...]:
        """The files that its runs can depend on: the project, its agents' sources, every AgentSpeak file below its
        folder.

        Raises:
            GenerateError: the project cannot be read.
        """
        # Imported here: a session that replays a suite declares its model, but needs no BDI engine.
        from pytest_hricdv.bdi import BdiError
        from pytest_hricdv.bdi.language.project import read_project

        try:
            sources = {entry.source for entry in read_project(self.path).agents}
        except (BdiError, OSError) as error:
            raise GenerateError(f"BDI model {self.path}: {error}") from error
        # Include files that are not an agent's source: they may be included by one, and changes must be noticed.
        return (self.path, *sorted(sources | set(self.path.parent.rglob("*.asl"))))

    def parts(self) -> list[list[Json]]:
        """All fields as plain data, sorted by name; the path is reduced to the file's name."""
        declared = {**asdict(self), "path": self.path.name}
        if not self.actors:
            del declared["actors"]  # models with one actor have the hash that they had before there were several
        return [[name, declared[name]] for name in sorted(declared)]

    def sha256(self) -> str:
        """Hash (hex) of its files and fields: models with the same hash behave the same.

        Folders do not count, so that another checkout has the same hash.

        Raises:
            GenerateError: a file cannot be read.
        """
        return digest("model", self.parts(), file_digests(self.files()))


@dataclass(frozen=True)
class ModelRun:
    """The outcome of one run of the model with one belief subset.

    Args:
        beliefs: the subset, in the space's order.
        lines: the external actions of the actor, or of all actors, in the text format: the abstract test.
        plans: the coverage plans executed, by covered agent.
        sequence: every covered plan executed, in order, by covered agent.
        rounds: reasoning rounds of the run.
        ended: how it ended, as the BDI engine reports it.
    """

    beliefs: tuple[str, ...]
    lines: tuple[str, ...]
    plans: Mapping[str, frozenset[str]] = field(hash=False)
    sequence: Plans = field(default_factory=dict, hash=False)
    rounds: int = 0
    ended: str = ""


class ExploredRun(NamedTuple):
    """A run of the model among all its runs; a named tuple because there are thousands.

    Args:
        lines: its abstract test.
        plans: the coverage plans executed, as bits.
        beliefs: the smallest belief set found for it, as bits.
    """

    lines: tuple[str, ...]
    plans: int
    beliefs: int


def file_digests(files: Iterable[Path]) -> list[list[str]]:
    """Name and SHA-256 (hex) of each file, sorted; their folders do not count.

    Raises:
        GenerateError: a file cannot be read.
    """
    digests = []
    for path in files:
        try:
            digests.append([path.name, sha256(read_bytes(path)).hexdigest()])
        except FileNotFoundError:
            raise GenerateError(f"{path}: no such file; expected a readable file") from None
        except MalformedError as error:
            raise GenerateError(f"{path}{error}") from None
    return sorted(digests)


def list_model(model: Model, root: Path) -> dict[str, Any]:
    """The model for a report: covered agent -> `file` (relative to `root`), `source`, `plans` (label -> line).

    Raises:
        GenerateError: a source cannot be read, or there is no such agent.
    """
    from pytest_hricdv.bdi import BdiError
    from pytest_hricdv.bdi.language.parser import read_program
    from pytest_hricdv.bdi.language.project import read_project

    try:
        project = read_project(model.path)
        sources = {entry.name: entry.source for entry in project.agents}
        listed = {}
        for agent in model.covered:
            path = sources[agent]
            plans = read_program(path).plans
            listed[agent] = {
                "file": Path(os.path.relpath(path, root)).as_posix(),
                "source": read_text(path),
                "plans": {plan.label: plan.location.line for plan in plans if plan.has_label},
            }
    except (BdiError, OSError, UnicodeDecodeError) as error:
        raise GenerateError(f"BDI model {model.path}: {error}") from error
    except KeyError as error:
        raise GenerateError(f"{model.path}: no agent {error} in this model") from None
    return listed


def beliefs_without_test(model: Model, beliefs: Iterable[str]) -> tuple[str, ...]:
    """The beliefs that no agent tests: in no trigger, context, condition, test goal or rule.

    Choosing them can change no test, whatever else the programs do with their names. None if a variable stands for
    a belief that is tested, or plans come during the run: then it is not known.

    Raises:
        GenerateError: a source cannot be read.
    """
    from pytest_hricdv.bdi import BdiError
    from pytest_hricdv.bdi.language.parser import read_program
    from pytest_hricdv.bdi.language.project import read_project
    from pytest_hricdv.bdi.language.terms import Structure
    from pytest_hricdv.bdi.lint.model_builder import build_model

    try:
        agents = [
            build_model(entry.name, str(entry.source), read_program(entry.source))
            for entry in read_project(model.path).agents
        ]
    except (BdiError, OSError) as error:
        raise GenerateError(f"BDI model {model.path}: {error}") from error
    triggers = [plan.trigger for agent in agents for plan in agent.plans]
    answered = [trigger.literal for trigger in triggers if trigger.sign in ("+?", "-?")]
    if any(not isinstance(trigger.literal, Structure) for trigger in triggers):
        return ()
    if any(agent.actions & _NAMELESS or any(sent.force in ("", "tellHow") for sent in agent.sent) for agent in agents):
        return ()
    tested = {mention.literal.functor for agent in agents for mention in agent.tests}
    tested |= {literal.functor for literal in answered if isinstance(literal, Structure)}
    return tuple(belief for belief in beliefs if belief not in tested)


_NAMELESS = frozenset({".add_plan", ".belief"})
"""Internal actions after which it is not known from the sources which beliefs are tested."""


@dataclass(frozen=True)
class Exploration:
    """All runs of the model, or the reason why they are not known.

    Args:
        plans: agent and label of each coverage plan, by the number of its bit.
        beliefs: the beliefs, by the number of their bit.
        runs: those with few beliefs first.
        reason: why these are not all runs; empty if they are.
    """

    plans: tuple[tuple[str, str], ...] = ()
    beliefs: tuple[str, ...] = ()
    runs: tuple[ExploredRun, ...] = ()
    reason: str = ""

    @property
    def complete(self) -> bool:
        """Whether these are all runs that exist."""
        return not self.reason

    def belief_set(self, bits: int) -> tuple[str, ...]:
        """The beliefs of a set, in declared order."""
        return tuple(belief for place, belief in enumerate(self.beliefs) if bits >> place & 1)

    def to_json(self) -> dict[str, Any]:
        """Plain data for a cache."""
        commands = sorted({line for run in self.runs for line in run.lines})
        codes = {line: chr(_FIRST_CODE + place) for place, line in enumerate(commands)}
        runs = [f"{''.join([codes[line] for line in run.lines])},{run.plans:x},{run.beliefs:x}" for run in self.runs]
        texts = {"schema": EXPLORATION_SCHEMA, "reason": self.reason, "commands": commands, "runs": "\n".join(runs)}
        return {**texts, "plans": [list(plan) for plan in self.plans], "beliefs": list(self.beliefs)}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Exploration:
        """The exploration that `to_json` gave. Raises GenerateError: it is of another version, or incomplete."""
        try:
            if data["schema"] != EXPLORATION_SCHEMA:
                raise GenerateError(f"an exploration of schema {data['schema']!r}; expected {EXPLORATION_SCHEMA!r}")
            commands = {chr(_FIRST_CODE + place): line for place, line in enumerate(data["commands"])}
            runs = []
            for text in data["runs"].split("\n") if data["runs"] else ():
                lines, plans, beliefs = text.split(",")
                runs.append(ExploredRun(tuple([commands[code] for code in lines]), int(plans, 16), int(beliefs, 16)))
            labelled = tuple((agent, label) for agent, label in data["plans"])
            return cls(labelled, tuple(data["beliefs"]), tuple(runs), data["reason"])
        except (KeyError, AttributeError, TypeError, ValueError) as error:
            raise GenerateError(f"an exploration that cannot be read: {error!r}") from None
