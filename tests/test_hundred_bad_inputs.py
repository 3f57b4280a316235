"""More than a hundred kinds of bad input: each a documented error with its place, short, legible, and soon.

What single limits and messages say is tested beside each reader; here all readers get all kinds.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from pytest_hricdv.bdi import BdiError, MultiAgentSystem
from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.beliefs import read_belief_sets
from pytest_hricdv.generate.context import GenerationContext
from pytest_hricdv.generate.model import Model
from pytest_hricdv.generate.saved_table import read_warm_start
from pytest_hricdv.generate.suite_files import Files
from pytest_hricdv.monitor import RequirementError, Vocabulary, load_requirements
from pytest_hricdv.results import replay
from pytest_hricdv.results.baseline import BaselineError, read_baseline
from pytest_hricdv.results.codec import ReportError, load
from pytest_hricdv.results.replay import ReplayError
from tests.generate.toy import LAMPS
from tests.hanging import ends
from tests.plugin import project

VOCABULARY = Vocabulary(signals={"p": bool, "x": float}, messages={"m": {}})


def _agent(path: Path) -> None:
    (path.parent / "of_agent.mas2j").write_text(f"MAS m {{ agents: a {path.name}; }}")
    MultiAgentSystem.load(path.parent / "of_agent.mas2j")


READERS: dict[str, tuple[str, Callable[[Path], object], type[Exception]]] = {
    "project": ("a.mas2j", MultiAgentSystem.load, BdiError),
    "agent": ("a.asl", _agent, BdiError),
    "requirements": ("a.toml", lambda path: load_requirements(path, VOCABULARY), RequirementError),
    "belief sets": ("a.toml", lambda path: read_belief_sets(path, LAMPS), GenerateError),
    "tests": ("a.txt", lambda path: Files(path).generate(GenerationContext()), GenerateError),
    "recorded tests": ("a.json", lambda path: Files(path).generate(GenerationContext()), GenerateError),
    "table": ("a.json", lambda path: read_warm_start(path, Model(Path("m.mas2j")), LAMPS), GenerateError),
    "replay": ("a.json", replay.load, ReplayError),
    "report": ("report.json", load, ReportError),
    "baseline": ("a.json", lambda path: read_baseline(path, "lamps"), BaselineError),
}
JSON = ("recorded tests", "table", "replay", "report", "baseline")
TOML = ("requirements", "belief sets")
LARGE = 500_000_001


def _make_large(path: Path) -> None:
    path.touch()
    os.truncate(path, LARGE)


FILES: dict[str, Callable[[Path], object]] = {
    "pipe": os.mkfifo,
    "device": lambda path: path.symlink_to("/dev/zero"),
    "link to itself": lambda path: path.symlink_to(path),
    "no text": lambda path: path.write_bytes(b"\xff\xfe\x00"),
    "too large": _make_large,
}
"""Kinds of files, for every reader."""

BROKEN_JSON = {
    "empty": "",
    "cut off": '{"schema": "hric',
    "deep": "[" * 100_000,
    "deep objects": '{"a":' * 100_000,
    "closed and deep": '{"schema": ' + "[" * 5000 + "]" * 5000 + "}",
    "5,000 digits": '{"schema": ' + "9" * 5000 + "}",
    "401 digits": '{"schema": 1' + "0" * 400 + "}",
    "infinity": '{"schema": Infinity}',
    "no number": '{"schema": NaN}',
    "no float": '{"schema": 1e400}',
    "list": "[1, 2]",
    "text": '"' + "\\u001b[31m" * 3000 + '"',
    "zeros": "\0" * 1000,
}
BROKEN_TOML = {
    "cut off": "[R1]\ntitle = ",
    "deep": "a = " + "[" * 5000 + "]" * 5000,
    "deep tables": "a." * 3000 + "b = 1",
    "5,000 digits": "[R1]\na = " + "9" * 5000,
    "401 digits": "[R1]\na = 1" + "0" * 400,
    "infinity": "[R1]\na = inf",
    "twice": "[R1]\ntitle = 'a'\n[R1]\n",
    "no table": "a = 3",
    "long key": f'["{"k" * 9000}"]\na = "\\u001b[31m\\u202e"',
    "zeros": "\0" * 1000,
}


def _requirement(formula: str, more: str = "") -> str:
    return f"[R1]\ntitle = 't'\nformula = \"always(p -> {formula})\"\n{more}"


def _test(header: str = "", command: str = "greet") -> str:
    return f"# id: t-1\n# suite: s\n# target: a\n# seed: 1\n{header}\n{command}\n"


TEXTS: dict[str, dict[str, str]] = {
    "requirements": {
        "operators": _requirement(" + ".join(["x"] * 3000) + " > 1"),
        "parentheses": _requirement("(" * 3000 + "p" + ")" * 3000),
        "negations": _requirement("!" * 3000 + "p"),
        "endless window": _requirement("eventually[0:1e300](p)"),
        "endless duration": _requirement("x > 1 [for 1e300]"),
        "endless unit": _requirement("x > 1 mm^999999999"),
        "doubling": _requirement("d40", "[definitions]\nd0 = 'p'\n" + "".join(
            f"d{n} = 'd{n - 1} & d{n - 1}'\n" for n in range(1, 41))),
        "circle": _requirement("d", "[definitions]\nd = 'e'\ne = 'd'\n"),
        "escape sequence": _requirement(r"\u001b[31m\u202e"),
        "long name": _requirement("y" * 50_000),
        "1,001 tables": "".join(f"[R{n}]\n" for n in range(1001)),
    },
    "belief sets": {
        "concretizations": '[[belief_set]]\nbeliefs = ["hall"]\nconcretizations = 999999999',
        "negative": '[[belief_set]]\nbeliefs = ["hall"]\nconcretizations = -1',
        "tests": '[[belief_set]]\nbeliefs = ["*"]\nconcretizations = 10000\n' * 12,
        "pattern": '[[belief_set]]\nbeliefs = ["[[[[*?"]',
        "long belief": f'[[belief_set]]\nbeliefs = ["{"x" * 100_000}"]',
    },
    "tests": {
        "suite": _test().replace("suite: s", "suite: ../../escaped"),
        "long suite": _test().replace("suite: s", f"suite: {'s' * 5000}"),
        "id": _test().replace("id: t-1", "id: ../../escaped"),
        "seed": _test().replace("seed: 1", f"seed: {'9' * 5000}"),
        "seed in other digits": _test().replace("seed: 1", "seed: ٣"),
        "value": _test("# values 1: x_m 1e999"),
        "values of a command": _test(f"# values {'9' * 5000}: x_m 1"),
        "command": _test(command="greet \x1b[31m\u202e" + "x" * 10_000),
        "twice": _test() + "\n" + _test(),
    },
    "project": {
        "copies": "MAS m { agents: a #00000000199999999; }",
        "copies in other digits": "MAS m { agents: a #٣; }",
        "agents": "MAS m { agents: " + "".join(f"a{n}; " for n in range(10_001)) + "}",
        "folders": "MAS m { aslSourcePath: " + '"a"; ' * 500 + "agents: a; }",
        "foreign file": "MAS m { agents: a /etc/hostname.; b /etc/os-release.x; }",
        "long name": f"MAS m {{ agents: {'a' * 5000} {'b' * 5000}; }}",
        "escape sequence": "MAS m { agents: \x1b[31m\u202e; }",
    },
    "agent": {
        "deep": "p(" + "f(" * 10_000 + ")" * 10_000 + ").",
        "deep list": "p(" + "[" * 10_000 + "]" * 10_000 + ").",
        "includes itself": '{ include("a.asl") }',
        "includes a folder": '{ include("/") }',
        "includes a device": '{ include("/dev/zero") }',
        "includes a foreign file": '{ include("/etc/passwd") }',
        "escape sequence": "+!g <- \x1b[31m\u202e.",
        "long token": "+!g <- " + "x" * 90_000 + " y.",
    },
    "recorded tests": {
        "steps": json.dumps({"s": [{"steps": 3}]}),
        "command": json.dumps({"s": [{"steps": ["\x1b[31m" * 2000]}]}),
        "number": json.dumps({"s": [{"n": [1], "steps": ["greet"]}]}),
    },
}  # fmt: skip


def kinds() -> Iterator[tuple[str, str, Callable[[Path], object]]]:
    """Reader, kind of input, and what makes it."""

    def text(content: str) -> Callable[[Path], object]:
        return lambda path: path.write_text(content, "utf-8")

    for reader in READERS:
        yield from ((reader, kind, make) for kind, make in FILES.items())
        broken = BROKEN_JSON if reader in JSON else BROKEN_TOML if reader in TOML else {}
        yield from ((reader, kind, text(content)) for kind, content in {**broken, **TEXTS.get(reader, {})}.items())


KINDS = [pytest.param(reader, make, id=f"{reader}: {kind}") for reader, kind, make in kinds()]


def assert_located(message: str, place: str) -> None:
    """The message names the place, is short, has no traceback, and nothing in it acts on a terminal."""
    assert place in message
    assert len(message) <= 1000
    assert "Traceback" not in message
    assert "INTERNALERROR" not in message
    assert all(char.isprintable() or char in "\n\t" for char in message)


def test_there_are_more_than_a_hundred_kinds() -> None:
    assert len({param.id for param in KINDS}) == len(KINDS) > 150


@pytest.mark.parametrize(("reader", "make"), KINDS)
def test_bad_input_is_a_located_error(tmp_path: Path, reader: str, make: Callable[[Path], object]) -> None:
    name, read, error = READERS[reader]
    make(tmp_path / name)
    with ends(), pytest.raises(error) as raised:
        read(tmp_path / name)
    assert_located(str(raised.value), str(tmp_path) if reader in ("agent", "project") else name)


def test_a_pipe_beside_the_sources_is_not_waited_for(tmp_path: Path) -> None:
    (tmp_path / "m.mas2j").write_text("MAS m { agents: a; }")
    (tmp_path / "a.asl").touch()
    os.mkfifo(tmp_path / "other.asl")
    with pytest.raises(GenerateError, match=r"other\.asl: not a regular file but a pipe"):
        Model(tmp_path / "m.mas2j").sha256()


@pytest.fixture(scope="module")
def lamps(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project, with some bad files."""
    folder = tmp_path_factory.mktemp("lamps")
    project.write(folder)
    os.mkfifo(folder / "pipe.txt")
    (folder / "escaped.txt").write_text(TEXTS["tests"]["suite"])
    (folder / "deep.json").write_text(BROKEN_JSON["deep"])
    return folder


@pytest.mark.slow
@pytest.mark.parametrize(
    "command", [["merge"], ["gate"], ["minimal", "-"], ["export", "--lcov=l"]], ids=lambda each: each[0]
)
@pytest.mark.parametrize("kind", ["pipe.txt", "deep.json", "escaped.txt"])
def test_a_command_on_a_bad_report_ends_with_one_located_line(lamps: Path, command: list[str], kind: str) -> None:
    name, *more = command
    folder = [str(lamps / "out") if each == "-" else each for each in more]
    arguments = [sys.executable, "-m", "pytest_hricdv.report", name, kind, *folder]
    done = subprocess.run(arguments, cwd=lamps, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 2
    assert_located(done.stderr.strip(), f"error: {kind}:")
