"""The tools, and the commands that run them in the folder of a code base."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

from studies.fair_fight import CodeBase

_PYTEST = ("-q", "--tb=no", "-p", "no:cacheprovider", "-p", "no:hypothesispytest")
_FUZZ = "from hypothesis.extra.cli import main; main()"
"""The command `hypothesis`, which is no module."""

Command = Callable[[CodeBase, int, Collection[str]], Sequence[str]]
"""Arguments of Python, of a code base, a seed, and the kinds of violations that are known."""


@dataclass(frozen=True)
class Tool:
    """A tool.

    Args:
        name: as `--only` names it.
        title: as the page calls it.
        command: of one session.
        package: what has to be installed for it, beside Hypothesis.
    """

    name: str
    title: str
    command: Command
    package: str = ""


def _suite(name: str, *options: str) -> Command:
    def command(base: CodeBase, seed: int, known: Collection[str]) -> Sequence[str]:
        # Faults are no requirements, and cannot be declared as known.
        declared = [f"--hri-known={kind}" for kind in known if " " not in kind] or ["--hri-strict"]
        ours = ["--hri-audit=off", "--hri-diagnose=0", "--hri-shrink", f"--hri-seed={seed}", *options, *declared]
        return ["-m", "pytest", *_PYTEST, *base.options, f"--hri-suite={name}", *ours]

    return command


def _driver(name: str) -> Command:
    def command(base: CodeBase, seed: int, known: Collection[str]) -> Sequence[str]:
        return ["-m", "studies.fair_fight.drive", name, base.name, str(seed)]

    return command


def _atheris(base: CodeBase, seed: int, known: Collection[str]) -> Sequence[str]:
    return ["-m", "studies.fair_fight.drive_atheris", base.name, ",".join(base.code), str(seed)]


def _hypofuzz(base: CodeBase, seed: int, known: Collection[str]) -> Sequence[str]:
    ours_off = ["-o", "hri_suite=", "-p", "no:cacheprovider"]
    return ["-c", _FUZZ, "fuzz", "--no-dashboard", "-n", "1", "--", "test_fuzzed.py", *ours_off]


TOOLS = (
    Tool("pseudorandom", "ours, `pseudorandom`", _suite("pseudorandom", "--hri-tests=50")),
    Tool("rl", "ours, `rl`", _suite("rl", "--hri-tests=50")),
    Tool("closure", "ours, `closure`", _suite("closure", "--hri-close-runs=100", "--hri-close-seconds=36000")),
    Tool("lists", "Hypothesis, lists", _driver("lists")),
    Tool("rules", "Hypothesis, rules", _driver("rules")),
    Tool("hypofuzz", "HypoFuzz", _hypofuzz, "hypofuzz"),
    Tool("atheris", "Atheris", _atheris, "atheris"),
    Tool("crosshair", "CrossHair", _driver("crosshair"), "hypothesis-crosshair"),
)
"""Pynguin, which makes unit tests and no runs, has a module of its own."""
