"""The folder of a campaign: its plan and the finished shards, all written atomically.

campaign.json   method, seed, number of tests, and what runs depend on, each file with its hash
tests.txt       the abstract tests, generated once
shards/         one file for each finished seed
lock            held while a campaign runs here
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path

from benchmarks.campaign import shard
from benchmarks.campaign.shard import Shard
from pytest_hricdv import atomic_file
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.suite_files import parse_tests

SCHEMA = "hricdv-campaign/1"
DIGITS = 64
"""Length of a SHA-256 in hexadecimal digits: distinguishes files from versions."""


class StateError(Exception):
    """A campaign cannot go on in its folder; the text says why and what to do."""


@dataclass(frozen=True)
class Plan:
    """What a campaign runs. Shards of different plans are never mixed.

    Args:
        method: the suite's name.
        master_seed: the abstract tests are generated from.
        count: of abstract tests asked for.
        depends: name -> hash or version, of all that a run's outcome depends on.
    """

    method: str
    master_seed: int
    count: int
    depends: Mapping[str, str]

    @property
    def identity(self) -> str:
        """One hash of all of it."""
        return hashlib.sha256(json.dumps(asdict(self), sort_keys=True).encode("utf-8")).hexdigest()

    def differences(self, other: Plan) -> list[str]:
        """Differences from another plan, such as `sim/leg.py changed` or `count was 160, is 80`."""
        names = ("method", "master_seed", "count")
        found = [
            f"{name} was {getattr(other, name)}, is {getattr(self, name)}"
            for name in names
            if getattr(other, name) != getattr(self, name)
        ]
        for name in sorted(self.depends.keys() | other.depends.keys()):
            before, now = other.depends.get(name), self.depends.get(name)
            if before is None:
                found.append(f"{name} is new")
            elif now is None:
                found.append(f"{name} is gone")
            elif before != now:
                found.append(f"{name} changed" if len(now) == DIGITS else f"{name} was {before}, is {now}")
        return found


class State:
    """A campaign's folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._plan = folder / "campaign.json"
        self._tests = folder / "tests.txt"
        self._shards = folder / "shards"

    @contextmanager
    def held(self) -> Iterator[None]:
        """Lock the folder, and remove the unfinished work of a killed campaign.

        Raises:
            StateError: another campaign runs in this folder.
        """
        self._shards.mkdir(parents=True, exist_ok=True)
        with (self.folder / "lock").open("w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise StateError(f"{self.folder}: another campaign runs in this folder: let it end first") from None
            for left in self.folder.glob("work-*"):
                shutil.rmtree(left, ignore_errors=True)
            yield

    @property
    def work(self) -> Path:
        """A folder for the unfinished shard, named after this process: pytest may outlive a killed campaign."""
        return self.folder / f"work-{os.getpid()}"

    def agree(self, plan: Plan) -> None:
        """Store this plan in a new folder, or check that the folder has the same plan.

        Raises:
            StateError: the folder has another plan.
        """
        if not self._plan.exists():
            atomic_file.write_text(
                self._plan, json.dumps({"schema": SCHEMA, **asdict(plan)}, sort_keys=True, indent=1) + "\n"
            )
            return
        before = self.plan()
        if before == plan:
            return
        raise StateError(
            f"{self.folder} holds {len(self.done())} shards of another campaign: {', '.join(plan.differences(before))}."
            " Results of different code are not mixed: go back to that code to end it, or give another --state folder"
            " (or remove this one) to begin anew."
        )

    def plan(self) -> Plan:
        """The plan of the folder. Raises StateError if there is none, or it cannot be read."""
        try:
            data = json.loads(self._plan.read_text(encoding="utf-8"))
            if data.pop("schema") != SCHEMA:
                raise StateError(f"{self._plan}: expected schema {SCHEMA!r}: give another --state folder")
            return Plan(**data)
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
            raise StateError(f"{self._plan}: no campaign ({error!r}): give another --state folder") from None

    def tests(self) -> tuple[AbstractTest, ...] | None:
        """The abstract tests; None if they were not generated yet."""
        if not self._tests.exists():
            return None
        return parse_tests(self._tests.read_text(encoding="utf-8"), file=str(self._tests), suite="")

    def keep_tests(self, text: str) -> None:
        """Store the abstract tests, as `dump_tests` writes them."""
        atomic_file.write_text(self._tests, text)

    def done(self) -> tuple[int, ...]:
        """Finished seeds, in order."""
        return tuple(sorted(int(path.stem.partition("-")[2]) for path in self._shards.glob("seed-*.json")))

    def keep(self, each: Shard) -> None:
        """Store a shard."""
        atomic_file.write_text(self._path(each.seed), each.to_json())

    def shard(self, seed: int) -> Shard:
        """The shard of a seed.

        Raises:
            ShardError: its file is damaged.
            StateError: it is one of another campaign.
        """
        path = self._path(seed)
        found = shard.read(path)
        if found.identity != self.plan().identity or found.seed != seed:
            raise StateError(f"{path}: a shard of another campaign or seed: remove it to run it again")
        return found

    def _path(self, seed: int) -> Path:
        return self._shards / f"seed-{seed:03}.json"
