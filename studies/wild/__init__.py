"""Public packages that nobody here wrote: at which commit, with which testbench, and how they are laid out.

`protocol.md` says how they were chosen, `packages.toml` which they are, `benches/` has a testbench for each.
"""

from __future__ import annotations

import hashlib
import shutil
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from studies.code_bases.ros2 import fetch

FOLDER = Path(__file__).parent
BENCHES = FOLDER / "benches"
COMMON = BENCHES / "common"


@dataclass(frozen=True)
class Source:
    """A repository at a commit.

    Args:
        repository: owner and name, at GitHub.
        commit: the one to be checked out.
        paths: what of it is needed, as patterns of `.gitignore`; without any, all.
    """

    repository: str
    commit: str
    paths: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Of the repository, without its owner."""
        return self.repository.rpartition("/")[2]

    def copy(self, clones: Path, target: Path) -> None:
        """Have a copy of its files in a folder. Raises FetchError where it cannot be cloned."""
        which = hashlib.sha256(repr(self.paths).encode()).hexdigest()[:6]
        clone = clones / "repositories" / f"{self.name}-{self.commit[:8]}-{which}"
        fetch(clone, f"https://github.com/{self.repository}", self.commit, self.paths)
        shutil.copytree(clone, target / self.name, ignore=shutil.ignore_patterns(".git"), symlinks=True)


@dataclass(frozen=True)
class Package:
    """A package of the study, or a known bug of one.

    Args:
        key: its name in `packages.toml`.
        title: as the page calls it.
        kind: "ROS 2" or "Python".
        sources: its repository, then what else it needs.
        benches: folders of its testbench; a later one replaces files of an earlier one.
        python_path: folders that Python imports from, below the folder of the run.
        reason: why it could not be run; empty where it was.
        tests: of the suite `rl`.
        close_runs: of the closing loop at most; 0: without it.
        cause_runs: in which causes are looked for, at most.
        schedules: runs with other schedules.
        verdicts: violated requirement -> "real", "by design" or "false alarm", and in a few words why.
    """

    key: str
    title: str
    kind: str
    sources: tuple[Source, ...]
    benches: tuple[Path, ...]
    python_path: tuple[str, ...]
    reason: str
    tests: int
    close_runs: int
    cause_runs: int
    schedules: int
    verdicts: dict[str, str]

    def files(self) -> dict[str, Path]:
        """The testbench: name of a file -> where it is kept."""
        kept = [path for folder in (COMMON, *self.benches) for path in sorted(folder.rglob("*")) if path.is_file()]
        folders = (COMMON, *self.benches)
        return {
            str(path.relative_to(next(each for each in folders if path.is_relative_to(each)))): path
            for path in kept
            if "__pycache__" not in path.parts
        }

    def lines(self) -> int:
        """Lines of the testbench that are not blank, with those that all have in common."""
        return sum(bool(line.strip()) for path in self.files().values() for line in path.read_text().splitlines())

    def fingerprint(self) -> str:
        """Of all that decides a result but the plugin."""
        parts = [
            *self.sources,
            self.python_path,
            self.tests,
            *([self.close_runs] if self.close_runs != 24 else ()),
            self.schedules,
        ]
        digest = hashlib.sha256(repr(parts).encode())
        for name, path in sorted(self.files().items()):
            digest.update(name.encode() + path.read_bytes())
        return digest.hexdigest()[:12]

    def lay(self, clones: Path) -> Path:
        """A new folder with the code and its testbench, in which `pytest` runs. Raises FetchError."""
        folder = clones / self.key
        shutil.rmtree(folder, ignore_errors=True)
        for source in self.sources:
            source.copy(clones, folder / "src")
        for name, path in self.files().items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, folder / name)
        ini = [
            "[pytest]",
            f"pythonpath = {' '.join(('.', *self.python_path))}",
            "hri_suite = rl",
            "testpaths = test_bench.py",
        ]
        (folder / "pytest.ini").write_text("\n".join(ini) + "\n", encoding="utf-8")
        return folder


def packages(path: Path = FOLDER / "packages.toml") -> Iterator[Package]:
    """All of them, in the order of the file."""
    for key, row in tomllib.loads(path.read_text(encoding="utf-8")).items():
        first = Source(row["repository"], row["commit"], tuple(row.get("paths", ())))
        further = [Source(name, commit, tuple(paths)) for name, commit, *paths in row.get("needs", ())]
        bench = BENCHES / key
        yield Package(
            key,
            row["title"],
            row["kind"],
            (first, *further),
            (bench,),
            tuple(row.get("python_path", ())),
            row.get("reason", "" if bench.is_dir() else "no testbench yet"),
            row.get("tests", 10),
            row.get("close_runs", 24),
            row.get("cause_runs", 24),
            row.get("schedules", 0),
            row.get("verdicts", {}),
        )
