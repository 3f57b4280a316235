"""`SavedTable`: a learned Q table in a file, with what is needed to check that it fits a model before more learning.

The method `ReinforcementLearning` writes it; `read_warm_start` reads it, or belief sets, for a session that learns on.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from hashlib import sha256
from pathlib import Path

from pytest_hricdv._base import atomic_file
from pytest_hricdv._base import own_json as json
from pytest_hricdv._base.input_file import MalformedError, from_json, read_text
from pytest_hricdv._base.message import quote
from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.beliefs import BeliefSpace, read_belief_sets
from pytest_hricdv.generate.learner import LearningResult
from pytest_hricdv.generate.model import Model
from pytest_hricdv.generate.qlearning import QLearning, QTable, WarmStart
from pytest_hricdv.generate.rng import canonical_json, digest
from pytest_hricdv.generate.suite import schema_of

SCHEMA = "hricdv-qtable/1"


@dataclass(frozen=True)
class SavedTable:
    """A learned table, and what it was learned from.

    Args:
        model: file name of the model.
        model_sha256: SHA-256 of the model's files and fields (`Model.sha256`).
        beliefs: group -> its beliefs, the start beliefs first.
        learning: the parameters of Q-learning (`QLearning`), by name.
        converged_at: the iteration at which it converged, or None.
        maxima: the most plans covered in one run, by agent.
    """

    model: str
    model_sha256: str
    beliefs: Mapping[str, tuple[str, ...]] = field(hash=False)
    learning: Mapping[str, bool | int | float | str | tuple[float, ...]] = field(hash=False)
    seed: int
    iterations: int
    converged_at: int | None
    maxima: Mapping[str, int] = field(hash=False)
    q: QTable = field(hash=False)

    @classmethod
    def of(
        cls, learned: LearningResult, model: Model, space: BeliefSpace, parameters: QLearning, seed: int
    ) -> SavedTable:
        """The table to save after learning."""
        made = (learned.iterations, learned.converged_at, learned.maxima, learned.q)
        return cls(model.path.name, model.sha256(), _groups(space), asdict(parameters), seed, *made)

    def to_json(self) -> str:
        """The file's text; floats are exact, equal tables give equal texts."""
        plain = {"schema": SCHEMA, **asdict(self)}
        return json.dumps(plain, sort_keys=True, indent=1, allow_nan=False) + "\n"

    @classmethod
    def from_json(cls, text: str, where: str) -> SavedTable:
        """The table that `to_json` wrote; `where` names its file in errors.

        Raises:
            GenerateError: cut off, of another version, or not what `to_json` writes.
        """
        expected = "expected what --hri-rl-save writes, with this version of the plugin"
        try:
            schema = schema_of(text)
            if schema != SCHEMA:
                raise GenerateError(f"{where}: expected schema {SCHEMA!r}, found {quote(schema)}; {expected}")
            return from_json(text, cls, strict=True)
        except MalformedError as error:
            raise GenerateError(f"{where}{error}; expected a saved table, or belief sets (*.toml)") from None

    def write(self, path: Path) -> None:
        """Write the file atomically. Raises GenerateError: it cannot be written."""
        try:
            atomic_file.write_text(path, self.to_json())
        except OSError as error:
            raise GenerateError(f"cannot write {path}: {error.strerror or error}; choose another file") from None

    def check(self, model: Model, space: BeliefSpace, where: str) -> None:
        """Check that it was learned on this model and these beliefs.

        Raises:
            GenerateError: it was not; names both hashes, or the groups that differ.
        """
        sha256 = model.sha256()
        if self.model_sha256 != sha256:
            raise GenerateError(
                f"{where}: a table of another model: it was learned on {self.model} of sha256 {self.model_sha256}, and "
                f"{model.path} has {sha256}; learn again, and save the result"
            )
        groups = _groups(space)
        if self.beliefs != groups:
            names = [name for name in {**self.beliefs, **groups} if self.beliefs.get(name) != groups.get(name)]
            raise GenerateError(
                f"{where}: a table of other belief groups: {', '.join(names) or 'in another order'}; learn again, "
                "and save the result"
            )
        for state in space.beliefs:
            cells = {belief for belief in space.others if belief != state}
            if (saved := self.q.get(state, {}).keys()) != cells:
                odd = sorted(saved ^ cells)[0]
                fault = "lacks" if odd in cells else "has the unknown cell"
                raise GenerateError(f"{where}: the row of {state!r} {fault} {odd!r}; was the file edited?")


def read_warm_start(path: Path, model: Model, space: BeliefSpace) -> WarmStart:
    """Read what learning begins with: a saved table, or a TOML file of belief sets as for the suite by-hand.

    Belief sets without a start belief, or with no other belief, are left out: Q has no cell for them.

    Raises:
        GenerateError: the file cannot be read, or is not for this model and these beliefs.
    """
    if path.suffix == ".toml":
        listed = [subset for entry in read_belief_sets(path, space) for subset in entry.subsets]
        subsets = tuple(filter(None, (_start_first(subset, space) for subset in listed)))
        if not subsets:
            raise GenerateError(f"{path}: no belief set with a start belief and another one; expected at least one")
        return WarmStart(path.name, digest("subsets", subsets), subsets=subsets)
    try:
        text = read_text(path)
    except FileNotFoundError:
        raise GenerateError(f"{path}: there is no such file") from None
    except MalformedError as error:
        raise GenerateError(f"{path}{error}; expected a saved table, or belief sets (*.toml)") from None
    saved = SavedTable.from_json(text, str(path))
    saved.check(model, space, str(path))
    # The seed and the parameters it was learned with have no effect on further learning.
    content = sha256(canonical_json([saved.q, saved.maxima]).encode("ascii")).hexdigest()
    return WarmStart(path.name, content, q=saved.q, maxima=saved.maxima)


def _start_first(subset: tuple[str, ...], space: BeliefSpace) -> tuple[str, ...]:
    """The set with one start belief in front; empty if it has no start belief or nothing else."""
    starts = [belief for belief in subset if belief in space.start]
    others = [belief for belief in subset if belief not in space.start]
    return (starts[0], *others) if starts and others else ()


def _groups(space: BeliefSpace) -> dict[str, tuple[str, ...]]:
    return {"start": space.start, **space.groups}
