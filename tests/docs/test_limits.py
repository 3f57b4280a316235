"""Every limit on what users hand over is in the table of the reference, and holds at its edge."""

from __future__ import annotations

import argparse
import ast
import importlib
import re
import sys
import zlib
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import NamedTuple, cast

import pytest
import zstandard

from pytest_hricdv._base.input_file import from_toml, read_bytes, unpack
from pytest_hricdv.bdi.language import limits
from pytest_hricdv.bdi.language.parser import parse_program
from pytest_hricdv.bdi.language.project import read_project
from pytest_hricdv.coupling.coupled_agent import CoupledRun
from pytest_hricdv.coverage.cross_product import CrossProduct
from pytest_hricdv.extra.campaign.__main__ import _number as number_of_campaign
from pytest_hricdv.extra.cluster import code_archive
from pytest_hricdv.extra.draft.code.loading import find
from pytest_hricdv.extra.draft.observe.observations import Observations, read_observations
from pytest_hricdv.extra.logs.expression import parse_expression
from pytest_hricdv.generate.abstract import AbstractTest, check_suite_name
from pytest_hricdv.generate.beliefs import BeliefSpace, read_belief_sets
from pytest_hricdv.generate.context import GenerationContext
from pytest_hricdv.monitor import MonitorSet, Vocabulary, check_requirement, load_requirements
from pytest_hricdv.monitor.build import always, on, signal
from pytest_hricdv.monitor.dsl import TruthValue
from pytest_hricdv.monitor.patterns.temporal import existence
from pytest_hricdv.monitor.requirement import Requirement
from pytest_hricdv.recordings.bags import Decoder, read_messages
from pytest_hricdv.recordings.containers import BagMessage, RecordedTopic, _unpack
from pytest_hricdv.recordings.recording import read_recordings
from pytest_hricdv.report.carrying import FileCarrier
from pytest_hricdv.results import codec, journal
from pytest_hricdv.runtime import Kernel
from pytest_hricdv.session.options import _shard
from tests.bdi.models import system_of
from tests.recordings.bags import write_mcap

PACKAGE = Path(sys.modules["pytest_hricdv"].__path__[0])
TABLE = (Path(__file__).parents[2] / "docs" / "reference.md").read_text(encoding="utf-8")
TABLE = TABLE.partition("### Limits\n")[2].partition("\n## ")[0]
VOCABULARY = Vocabulary(signals={"p": bool, "x": float})


class Limit(NamedTuple):
    """A limit, and how it is reached.

    Args:
        constant: module:NAME.
        try_out: hands over so much of it, in a folder.
        message: of the error, where it is more.
        figure: the limit as in the table; its value if empty.
        low: a lower limit for the test; 0: the limit itself.
        step: by how much is more than the limit, where not by one.
    """

    constant: str
    try_out: Callable[[int, Path], object]
    message: str
    figure: str = ""
    low: int = 0
    step: int = 1


def steps_of_node(number: int, _: Path) -> None:
    kernel = Kernel()

    def hurry() -> None:
        for _ in range(number - 1):
            kernel.sleep(1e-6)
        kernel.sleep(0.1)
        kernel.sleep(1.0)

    kernel.spawn("robot", hurry)
    kernel.run(2.0)


def sparse(path: Path, size: int) -> Path:
    with path.open("wb") as file:
        file.truncate(size)
    return path


def requirement(folder: Path, response: str, definitions: str = "") -> object:
    file = folder / "r.toml"
    file.write_text(f'[definitions]\n{definitions}\n[R]\ntitle = "t"\nformula = "always(p -> {response})"\n')
    return load_requirements(file, VOCABULARY)


def requirements_of_size(size: int, folder: Path) -> object:
    requirement(folder, "p")
    text = (folder / "r.toml").read_text()
    (folder / "r.toml").write_text(text + "\n" * (size - len(text)))
    return load_requirements(folder / "r.toml", VOCABULARY)


def definitions_in_each_other(depth: int, folder: Path) -> object:
    return requirement(folder, "p", f'd0 = "{"!" * 29}p"\nd1 = "{"!" * (depth - 31)}d0"')


def built_in_python(depth: int, _: Path) -> None:
    condition: TruthValue = signal("p")
    for _operator in range(depth // 2 - 1):
        condition = ~condition
    formula = always(signal("p") >> condition)
    check_requirement(Requirement("R", "", "", str(formula), formula), VOCABULARY)


def includes(files: int, folder: Path, *, in_each_other: bool) -> object:
    for number in range(files):
        next_one = f'{{ include("f{number + 1}.asl") }}\n' if in_each_other and number < files - 1 else ""
        (folder / f"f{number}.asl").write_text(next_one)
    first = range(1 if in_each_other else files)
    return system_of(folder, a="\n".join(f'{{ include("f{number}.asl") }}' for number in first))


def project(folder: Path, agents: str, sections: str = "") -> object:
    (folder / "mas.mas2j").write_text(f"MAS m {{ {sections} agents: {agents}; }}")
    return read_project(folder / "mas.mas2j")


def run_agent(folder: Path, source: str) -> object:
    return system_of(folder, a=source).run()


def make_new_agents(count: int, folder: Path) -> object:
    (folder / "b.asl").write_text("")
    return run_agent(
        folder, f'!g. +!g <- for (.range(I, 2, {count})) {{ .concat("b", I, N); .create_agent(N, "b.asl") }}.'
    )


def work(units: int, _: Path) -> None:
    with limits.count_work(SimpleNamespace(work_left=limits.MAX_WORK)):
        limits.spend(units)


def wait_without_end(count: int, _: Path) -> None:
    run = CoupledRun()
    for _cycle in range(count):
        run.wait_until(0.0)


def report_of_size(size: int, folder: Path) -> object:
    sparse(folder / "report.json", size)
    try:
        return codec.load(folder / "report.json")
    except codec.ReportError as error:
        if "too large" in str(error):
            raise
        return None  # zeros are no report


def recorded(number: int, folder: Path) -> None:
    file = write_mcap(folder / "run.mcap", [(float(n), "/said", {}) for n in range(number)])
    (recording,) = read_recordings([file], lambda topic: True, lambda kind: None)
    if recording.problems:
        raise ValueError(recording.problems[0])


def jumping(number: int, folder: Path) -> None:
    file = write_mcap(folder / "run.mcap", [(1000.0 * n, "/said", {}) for n in range(number)])
    (recording,) = read_recordings([file], lambda topic: True, lambda kind: None)
    if recording.is_cut:
        raise ValueError(recording.problems[0])


def computed(number: int, _: Path) -> None:
    for problem in parse_expression("a".ljust(number, "a")).problems("level"):
        raise ValueError(problem)


def padded(number: int, folder: Path) -> None:
    file = write_mcap(folder / "run.mcap", [(0.0, "/said", b" " * 999_900)] * number, packed=True)
    assert len([*read_messages(file)]) == number


def defined(number: int, _: Path) -> None:
    text = "uint8 a  # ".ljust(number, "x")
    Decoder(lambda kind: None).fields(
        BagMessage(0, b"\x00\x01\x00\x00\x01", RecordedTopic("/a", "a_msgs/msg/A", "cdr", text))
    )


def carried(size: int, folder: Path) -> object:
    (folder / "failures").mkdir(exist_ok=True)
    sparse(folder / "failures" / "a.json", size)
    return FileCarrier([folder], folder / "target")


def sent(size: int, folder: Path) -> object:
    return code_archive.pack(folder, [sparse(folder / "data", size)])


def belief_sets(count: int, folder: Path) -> object:
    file = folder / "by_hand.toml"
    file.write_text(f'[[belief_set]]\nbeliefs = ["a"]\nconcretizations = {count}\n')
    return list(read_belief_sets(file, BeliefSpace(start=("a",), groups={})))


def with_seed(seed: int) -> AbstractTest:
    return AbstractTest("t", "s", "t", (), ("press",), seed=seed)


def option_value(text: str) -> pytest.Config:
    """A configuration whose options all have this value."""
    return cast("pytest.Config", SimpleNamespace(getoption=lambda _: text))


def source_of_size(size: int, folder: Path) -> object:
    (folder / "robot.py").write_bytes(b"\n" * size)
    return find("robot", folder)


def recording_of_size(size: int, folder: Path) -> object:
    text = Observations().to_json()
    (folder / "seen.json").write_text(text + " " * (size - len(text)), encoding="utf-8")
    return read_observations(folder / "seen.json")


LIMITS = (
    Limit("_base.input_file:MAX_BYTES", lambda n, at: read_bytes(sparse(at / "f", n)), "too large"),
    Limit("_base.input_file:MAX_REPORT_BYTES", report_of_size, "too large", low=1000),
    Limit("_base.input_file:MAX_TOML_BYTES", requirements_of_size, "r.toml: too large"),
    Limit(
        "_base.input_file:MAX_UNPACKED_BYTES",
        lambda n, _: unpack(zlib.compress(bytes(n)), limit_of("_base.input_file:MAX_UNPACKED_BYTES")),
        "unpacks to too much",
        low=1000,
    ),
    Limit("_base.input_file:MAX_DEPTH", lambda n, _: from_toml("a = " + "[" * n + "]" * n), "nested too deeply"),
    Limit("_base.input_file:MAX_DIGITS", lambda n, _: from_toml("a = " + "9" * n), "at most 19 digits"),
    Limit(
        "bdi.language.parser:MAX_SOURCE",
        lambda n, at: parse_program("//" + "x" * (n - 2)) and run_agent(at, "//" + "x" * (n - 2)),
        "too large",
    ),
    Limit(
        "bdi.language.parser:MAX_FILES", lambda n, at: includes(n - 1, at, in_each_other=False), "more than 1,000 files"
    ),
    Limit("bdi.language.parser:MAX_INCLUDE_DEPTH", lambda n, at: includes(n, at, in_each_other=True), "more than 50"),
    Limit("bdi.language.project:MAX_AGENTS", lambda n, at: project(at, f"a; b #{n - 1}"), "mas2j:1:.*10,000 together"),
    Limit("bdi.language.project:MAX_AGENTS", make_new_agents, "a.asl:1:.*more than 5 agents", "10,000", 5),
    Limit("bdi.language.project:MAX_FOLDERS", lambda n, at: project(at, "a", "aslSourcePath:" + '"a";' * n), "100"),
    Limit(
        "bdi.language.syntax_errors:MAX_DEPTH",
        lambda n, _: parse_program("p(" + "[" * (n - 1) + "]" * (n - 1) + ")."),
        ":1:.*more than 120 levels of brackets",
    ),
    Limit(
        "bdi.logic.inference:MAX_CHOICES",
        lambda n, at: run_agent(at, f"p(1). p(N) :- N > 1 & p(N - 1). !g. +!g : p({n}) <- true."),
        "rule p.* in",
        low=50,
    ),
    Limit(
        "bdi.logic.inference:MAX_NESTED_QUERIES",
        lambda n, at: run_agent(at, f"q(0). q(N) :- N > 0 & not q(N - 1). !g. +!g : q({n - 1}) <- true. -!g."),
        "more than 60 queries",
    ),
    Limit("bdi.language.limits:MAX_WORK", work, "within 10,000,000 steps"),
    Limit(
        "bdi.language.limits:MAX_SIZE",
        lambda n, at: run_agent(at, f"!g. +!g <- .findall(f, .range(I, 1, {n // 2}), L); +p."),
        "a.asl:1:.*more than 100 parts",
        low=100,
        step=2,
    ),
    Limit("bdi.language.limits:CHARACTERS", lambda n, _: limits.check_text(n * 1_000_000), "characters", "16,000,000"),
    Limit("bdi.language.limits:MAX_ANSWERS", lambda n, _: [*limits.limit_answers(iter(range(n)))], "1,000,000 answers"),
    Limit("bdi.language.limits:MAX_HELD", lambda n, at: run_agent(at, "p. " * n), "mas2j:1:.*than 5 beliefs", low=5),
    Limit("coupling.coupled_agent:MAX_CYCLES", wait_without_end, "more than 10,000 times without time passing"),
    Limit(
        "coverage.cross_product:MAX_BINS",
        lambda n, _: CrossProduct({"a": tuple(map(str, range(n)))}),
        "cross product of a: more than 100000 bins",
    ),
    Limit("extra.campaign.database:MAX_K", lambda n, _: number_of_campaign(str(n)), "from 1 to 10,000,000"),
    Limit("extra.draft.code.loading:MAX_BYTES", source_of_size, "longer than 1,000 bytes", low=1000),
    Limit("extra.draft.observe.observations:MAX_BYTES", recording_of_size, "at most 1,000 bytes", low=1000),
    Limit("extra.cluster.code_archive:MAX_BYTES", sent, "data included: install the project", low=1000),
    Limit("generate.abstract:MAX_SUITE_NAME", lambda n, _: check_suite_name("a" * n), "at most 100"),
    Limit("generate.abstract:SEED_LIMIT", lambda n, _: with_seed(n - 1), "below 2|< 2", "2^63"),
    Limit("generate.beliefs:MAX_TESTS", belief_sets, "by_hand.toml:2:1: .* expected at most 100000"),
    Limit("session.options:MAX_TESTS", lambda n, _: GenerationContext(tests=n), "expected a number from 1 to 100000"),
    Limit("monitor.syntax_tree:MAX_LENGTH", lambda n, at: requirement(at, "p".ljust(n - 13)), "100,001 characters"),
    Limit("monitor.syntax_tree:MAX_DEPTH", lambda n, at: requirement(at, "!" * (n - 2) + "p"), "r.toml:5:.*than 64"),
    Limit("monitor.syntax_tree:MAX_DEPTH", definitions_in_each_other, "r.toml:.*more than 64"),
    Limit("monitor.syntax_tree:MAX_BUILT_DEPTH", built_in_python, "more than 128 levels of operators", step=2),
    Limit(
        "monitor.syntax_tree:MAX_NODES",
        lambda n, at: requirement(at, " & ".join(["d"] * (n // 2)), 'd = "p"'),
        "r.toml:5:.*more than 50 operators",
        "10,000",
        50,
        2,
    ),
    Limit("runtime.kernel:MAX_STEPS", steps_of_node, r"robot at 0.105 s: more than 5,000 steps .*test_limits.py:\d+"),
    Limit("monitor.units:MAX_TIME_S", lambda n, at: requirement(at, f"eventually[0:{n}](p)"), "r.toml:5:", "10^9"),
    Limit("monitor.patterns.temporal:MAX_IN_SCOPE", lambda n, _: existence(on("m"), at_most=n, after=on("k")), "20"),
    Limit(
        "monitor.evaluation_state:LAST_NS",
        lambda n, _: MonitorSet([]).advance(n / 1e9),
        r"at most 4.6e\+09 s",
        "146",
        step=2**10,
    ),
    Limit("recordings.message_order:MAX_VALUES", recorded, "run.mcap: has more than 9 messages", low=9),
    Limit("recordings.message_order:MAX_PARTS", jumping, "run.mcap: its clock jumps more than 9 times", low=9),
    Limit("extra.logs.expression:MAX_CHARACTERS", computed, "level: expression 'a+.* has more than 1,000 characters"),
    Limit(
        "recordings.containers:MAX_MESSAGE_BYTES",
        lambda n, _: _unpack(SimpleNamespace(compression="zstd", data=zstandard.compress(bytes(n)))),
        "a chunk unpacks to more than 1,000 bytes",
        low=1000,
    ),
    Limit("recordings.containers:MAX_UNPACKING", padded, "run.mcap: unpacks to more than 2 times", low=2),
    Limit("recordings.bags:MAX_DEFINITION", defined, "type a_msgs/msg/A: its definition has more than", low=1000),
    Limit("report.carrying:_MAX_BYTES", carried, "a.json: too large", low=1000),
    Limit("results.gates:MAX_SHARDS", lambda n, _: _shard(option_value(f"1/{n}")), "OF at most 9999"),
    Limit(
        "results.journal:MAX_BYTES", lambda n, at: journal.read(sparse(at / "j", n)), "more than 1,000 bytes", low=1000
    ),
)

NOT_OF_INPUT = {
    "_base.input_file:_BLOCK": "how much is read at once",
    "bdi.memo.decision_diagram:MAX_NODES": "an exploration that has more draws samples",
    "bdi.memo.decision_diagram:MAX_RUNS": "as MAX_NODES",
    "execution.forks:_LOOK_AFTER_S": "how often a process is looked at",
    "execution.forks:MAX_ATTEMPTS": "how often what was lost is tried again",
    "extra.cluster.connection:MAX_RESTARTS": "how often a connection is made again",
    "extra.draft.code.constants:MAX_DEPTH": "what is deeper in the code is not evaluated",
    "extra.draft.observe.observations:VERSION": "of the format",
    "extra.draft.project.requirements:STAY_S": "part of a requirement that is drafted",
    "extra.ros2.frame_tree:_GRAPH_DEPTH": "of tf2: a deeper tree has a loop",
    "extra.ros2.messages:NS_PER_S": "a unit",
    "extra.ros2.overlay:_MAX_IMPORTERS": "so many are named",
    "extra.suggestion.suggest:MIN_TESTS": "the least that is needed",
}
"""Constants of errors that are no limits of what users hand over, and what they are."""

TIMES = {
    "coverage.import_process:TIMEOUT_S": "120 s",
    "session.early_end:AT_EXIT_WITHIN_S": "30 s",
    "extra.cluster.cluster:WAIT_FOR_LOCAL_S": "30 s",
    "extra.cluster.cluster:WAIT_FOR_WORKERS_S": "60 s",
    "extra.cluster.connection:WAIT_FOR_SCHEDULER_S": "120 s",
    "recordings.bags:DEFINED_WITHIN_S": "10 s",
    "runtime.supervision:STUCK_AFTER_S": "8 s",
    "_base.error_text:TEXT_WITHIN_S": "1 s",
    "runtime.supervision:NODE_WAITS_S": "0.5 s",
    "runtime.supervision:WORLD_WAITS_S": "60 s",
    "runtime.livelock:NOTHING_NEW_S": "180 s",
    "extra.search.post_session:RUN_S": "120 s",
    "session.child_process:RUN_S": "60 s",
    "extra.film.video:ENCODER_TIMEOUT_S": "60 s",
}
"""Limits of time are in the table as they are here; their edges would have to be waited for."""

_CONSTANT = re.compile(r"_?[A-Z][A-Z0-9_]*\Z")
_WORDS = re.compile(r"at most|more than|expected|from \d+ to")
_READERS = ("read_text", "read_bytes", "unpack")
"""Functions that are told how much they may read."""


def limit_of(constant: str) -> int:
    module, _, name = constant.partition(":")
    return cast(int, getattr(importlib.import_module(f"pytest_hricdv.{module}"), name))


def constants_of(tree: ast.Module, nodes: Iterable[ast.AST], module: str) -> dict[str, str]:
    """Of a module: name in it -> module:NAME of where it comes from."""
    found: dict[str, str] = {}
    for node in nodes:
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("pytest_hricdv."):
            found |= {alias.asname or alias.name: f"{node.module}:{alias.name}" for alias in node.names}
    for line in tree.body:
        if isinstance(line, ast.Assign) and isinstance(line.targets[0], ast.Name):
            found[line.targets[0].id] = f"{module}:{line.targets[0].id}"
    return {name: place.removeprefix("pytest_hricdv.") for name, place in found.items() if _CONSTANT.match(name)}


def refusals(nodes: Iterable[ast.AST]) -> Iterator[ast.AST]:
    """Where something is refused: conditions of errors, errors, their texts, and how much readers may read."""
    for node in nodes:
        if isinstance(node, ast.If) and any(isinstance(line, ast.Raise) for line in node.body):
            yield node.test
        elif isinstance(node, ast.Raise) or (isinstance(node, ast.JoinedStr) and _WORDS.search(ast.unparse(node))):
            yield node
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in _READERS:
            yield from node.args
        elif isinstance(node, ast.FunctionDef) and node.name in _READERS:
            yield from node.args.defaults


@cache
def constants() -> tuple[dict[str, set[str]], set[str]]:
    """Constants of the package with the modules that know them, and those by which something is refused."""
    texts = {path: path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py")}
    numeric = set(re.findall(r"(?m)^(_?[A-Z][A-Z0-9_]*) = [\d(]", "\n".join(texts.values())))
    known: dict[str, set[str]] = {}
    refusing: set[str] = set()
    for path, text in texts.items():
        if numeric.isdisjoint(re.findall(r"\b_?[A-Z][A-Z0-9_]+\b", text)):
            continue
        module = ".".join(("pytest_hricdv", *path.relative_to(PACKAGE).with_suffix("").parts)).removesuffix(".__init__")
        tree = ast.parse(text)
        nodes = list(ast.walk(tree))
        own = constants_of(tree, nodes, module)
        for place in own.values():
            known.setdefault(place, set()).add(module)
        names = (part.id for spot in refusals(nodes) for part in ast.walk(spot) if isinstance(part, ast.Name))
        refusing |= {own[name] for name in names if name in own and own[name].partition(":")[2] in numeric}
    return known, {place for place in refusing if type(limit_of(place)) in (int, float)}


def test_no_constant_that_refuses_input_is_forgotten() -> None:
    assert constants()[1] - {limit.constant for limit in LIMITS} - set(TIMES) - set(NOT_OF_INPUT) == set()


def test_the_table_has_each_limit_with_its_option_or_reason() -> None:
    rows = [line.strip("|").split("|") for line in TABLE.replace("\\|", "").splitlines() if line.startswith("|")]
    assert all(len(row) == 3 and all(map(str.strip, row)) for row in rows)
    figures = {*(limit.figure or f"{limit_of(limit.constant):,}" for limit in LIMITS), *TIMES.values()}
    assert not {figure for figure in figures if not any(figure in row[1] for row in rows)}
    for constant, figure in TIMES.items():
        assert f"{limit_of(constant):g} s" == figure


@pytest.mark.parametrize("limit", LIMITS, ids=lambda limit: f"{limit.constant}-{limit.figure}".strip("-"))
def test_a_limit_holds_at_its_edge(limit: Limit, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    most = limit.low or int(limit_of(limit.constant))
    if limit.low:
        for module in constants()[0][limit.constant]:
            monkeypatch.setattr(importlib.import_module(module), limit.constant.partition(":")[2], most)
    accepted, refused = tmp_path / "accepted", tmp_path / "refused"
    accepted.mkdir()
    refused.mkdir()
    limit.try_out(most, accepted)
    with pytest.raises((Exception, argparse.ArgumentTypeError)) as caught:
        limit.try_out(most + limit.step, refused)
    assert re.search(limit.message, str(caught.value))
