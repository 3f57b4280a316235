"""What is fuzzed: each parser and loader, with inputs that it accepts and the errors that it documents."""

from __future__ import annotations

import contextlib
import json
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from random import Random

from pytest_hricdv._base.message import InputError
from pytest_hricdv.bdi import BdiError
from pytest_hricdv.bdi.language.parser import parse_plan, parse_program, parse_term
from pytest_hricdv.bdi.run.system import MultiAgentSystem
from pytest_hricdv.extra.evidence.requirement_lists import read_requirements
from pytest_hricdv.extra.logs.log_map import read_map
from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.beliefs import read_belief_sets
from pytest_hricdv.generate.concrete import ConcreteTest, expand
from pytest_hricdv.generate.context import GenerationContext
from pytest_hricdv.generate.saved_table import SavedTable
from pytest_hricdv.generate.suite import Suite
from pytest_hricdv.generate.suite_files import Files, dump_tests
from pytest_hricdv.monitor import RequirementError, Vocabulary, load_requirements, parse_condition, parse_formula
from pytest_hricdv.monitor.program import compile_condition, compile_formula
from pytest_hricdv.report import junit, markdown, terminal
from pytest_hricdv.report.__main__ import minimal_tests
from pytest_hricdv.results import journal
from pytest_hricdv.results.baseline import BaselineError, baseline_of, check_suites, read_baseline
from pytest_hricdv.results.behaviour_diff import compare_behaviour
from pytest_hricdv.results.codec import ReportError, canonical, load
from pytest_hricdv.results.gates import (
    ALLOWED_UNTRIGGERED,
    KNOWN,
    ExemptionError,
    ThresholdError,
    parse_exemption,
    parse_threshold,
)
from pytest_hricdv.results.merging import MergeError, merge
from pytest_hricdv.results.replay import Replay, ReplayError
from pytest_hricdv.results.report_builder import rebuild
from studies.session import ROOT, start
from tests.generate.toy import LAMPS
from tests.plugin import project

VOCABULARY = Vocabulary(
    signals={"lamp_level": float, "p": bool, "x": float, "name": str},
    messages={"wish": {}, "switched": {}, "greeting": {"text": str}, "answer": {"ok": bool, "level": float}},
    units={"x": "m/s"},
)
_FORMULAS = [
    "always(on(wish) -> eventually[0:1](on(switched)))",
    "always(lamp_level > 0 & !p -> lamp_level <= 80 [hysteresis 2] | x < 5 mm/s [for 0.5])",
    "always(rise(p) since name == 'a' -> always[0:2.5](once[0:1](p) | historically(x + 2 * x / 3 > -1)))",
    "always(answer.ok & last(answer.level) > 1 -> always(count[0:5](on(wish)) < 3) until time_since(p) > 2)",
    "always(previously(p) -> time_between(on(wish), on(switched)) < 3)",
]
_MAP = """
time = "header"
gap_s = 0.5

[messages.answer]
topic = "/answer"
fields.ok = { path = "said", equals = "yes" }
fields.level = { expression = "hypot(a.x, -a.y) / 2 + 1" }

[signals.x]
topic = "/base"
value = { path = "speed", unit = "cm/s" }
every_s = 0.1

[actions.wish]
topic = "/wish"
command = "set_lamp level = {percent}"
only = { sender = "tablet" }
parameters.pause_s = "pause"
"""
_NEEDS = '{"current_version": "1", "versions": {"1": {"needs": {"R-1": {"title": "a", "content": "b"}}}}}'
_SOURCES = ("a.asl", "b.asl", "c.asl", "ann.asl", "bob.asl")
"""Files that projects name: empty ones are enough."""
_TERMS = ['f(X, [1, "a"|T], -2.5)[source(self)]', "{+!g(X) : p & not q <- a; ?b; !c}"]


@dataclass(frozen=True)
class Target:
    """A reader.

    Args:
        read: reads a text; it may be given a path to write it to.
        seeds: texts that it accepts.
        errors: what it documents to raise.
        is_json: whether its texts are JSON, which is edited as such, too.
    """

    read: Callable[[str, Path], object]
    seeds: list[str]
    errors: tuple[type[Exception], ...]
    is_json: bool = False


def targets(folder: Path) -> dict[str, Target]:
    """All readers by name; a session in an empty folder makes the files to begin with."""
    project.write(folder)
    options = ["--hri-suite=by-hand,rl", "--hri-tests=1", "--hri-rl-save=q.json", "--hri-export=suites", "--hri-strict"]
    start([*options, "--hri-baseline=base.json", "--hri-update-baseline", "--hri-report=report"], folder)
    texts = sorted((folder / "suites").glob("*.txt"))
    suites = [Files(path).generate(GenerationContext()) for path in texts]
    toml = [project.REQUIREMENTS, _tables(_FORMULAS)]
    sources = [path.read_text("utf-8") for path in sorted(ROOT.glob("tests/bdi/programs/*/*.asl"))[::8]]
    sources += [path.read_text("utf-8") for path in sorted(ROOT.glob("models_bdi/*.asl"))]
    projects = [path.read_text("utf-8") for path in sorted(ROOT.glob("tests/bdi/programs/*/*.mas2j"))[::8]]
    replays = [path.read_text("utf-8") for path in sorted((folder / "report" / "failures").glob("*.json"))]
    report = (folder / "report" / "report.json").read_text("utf-8")
    table, base = (folder / "q.json").read_text("utf-8"), (folder / "base.json").read_text("utf-8")
    recorded = json.dumps({suite.name: [{"n": 1, "steps": list(suite.tests[0].lines)}] for suite in suites})
    lines = (folder / "report" / journal.NAME).read_text("utf-8").splitlines()
    records = f"[{','.join(line.split(' ', 2)[2] for line in lines)}]"
    (folder / "whole.json").write_text(report, "utf-8")
    whole = load(folder / "whole.json")

    def read_report(text: str, path: Path) -> None:
        read = load(_written(path, text))
        merged = merge([("a", read), ("b", read), ("c", whole)] if read.suites == whole.suites else [("a", read)])
        canonical(merged)
        minimal_tests(merged)
        terminal.summary(merged, path)
        markdown.markdown(merged)
        junit.junit_suite_properties(merged)

    def read_base(text: str, path: Path) -> None:
        baseline = read_baseline(_written(path, text), whole.testbench)
        check_suites(baseline, {suite.name: suite.seed for suite in whole.suites}, "b", behaviour=True)
        compare_behaviour(whole, baseline, whole=True)
        baseline_of(whole, baseline)

    def read_tests(text: str, path: Path) -> None:
        suite = Files(_written(path, text)).generate(GenerationContext())
        dump_tests(expand(suite.tests, 2))

    concrete = [Replay.from_json(text, "r").concrete.to_json() for text in replays]
    return {
        "program": Target(lambda text, _: parse_program(text), sources, (BdiError,)),
        "term": Target(_read_term, _TERMS, (BdiError,)),
        "project": Target(_read_project, projects, (BdiError,)),
        "formula": Target(_read_formula, _FORMULAS, (RequirementError,)),
        "requirements": Target(_read_requirements, toml, (RequirementError,)),
        "belief sets": Target(
            lambda text, path: read_belief_sets(_written(path, text), LAMPS), [project.BY_HAND], (GenerateError,)
        ),
        "tests": Target(read_tests, [path.read_text("utf-8") for path in texts], (GenerateError,)),
        "recorded": Target(
            lambda text, path: read_tests(text, path.with_suffix(".json")), [recorded], (GenerateError,), is_json=True
        ),
        "suite": Target(
            lambda text, _: Suite.from_json(text), [suite.to_json() for suite in suites], (GenerateError,), is_json=True
        ),
        "concrete": Target(lambda text, _: ConcreteTest.from_json(text), concrete, (GenerateError,), is_json=True),
        "table": Target(lambda text, _: SavedTable.from_json(text, "q"), [table], (GenerateError,), is_json=True),
        "replay": Target(lambda text, _: Replay.from_json(text, "r"), replays, (ReplayError,), is_json=True),
        "report": Target(read_report, [report], (ReportError, MergeError), is_json=True),
        "baseline": Target(read_base, [base], (BaselineError, ReportError), is_json=True),
        "journal": Target(_read_journal, [records], (ValueError,), is_json=True),
        "gate": Target(
            _read_gate,
            ["R1: slow", "R3 when x > 2 until 2027-01-31: a reason"],
            (ThresholdError, ExemptionError),
        ),
        "map": Target(lambda text, path: read_map(_written(path, text), VOCABULARY), [_MAP], (InputError,)),
        "needs": Target(
            lambda text, path: read_requirements(_written(path.with_suffix(".json"), text)), [_NEEDS], (ReportError,),
            is_json=True,
        ),
    }  # fmt: skip


def _written(path: Path, text: str) -> Path:
    path.write_text(text, "utf-8", "surrogatepass")
    return path


def _tables(formulas: list[str]) -> str:
    definitions = '[definitions]\nmoved = "x > 0.5"\nboth = "moved & p"\n'
    tables = (f'[R{n}]\ntitle = "t"\nformula = "{text}"\n' for n, text in enumerate(formulas))
    return definitions + "".join(tables) + '[P]\ntitle = "t"\npattern = "response(on(wish), both, within_s=3)"\n'


def _read_journal(text: str, path: Path) -> None:
    """A journal with valid checksums, of records that may be anything."""
    try:
        bodies = [json.dumps(record).encode() for record in json.loads(text)]
    except (ValueError, RecursionError, TypeError):
        bodies = [text.replace("\n", " ").encode("utf-8", "surrogatepass")]
    path.write_bytes(b"".join(b"%08x %d %s\n" % (zlib.crc32(body), len(body), body) for body in bodies))
    canonical(rebuild(journal.read(path))[0])


def _read_term(text: str, _: Path) -> None:
    with contextlib.suppress(BdiError):
        parse_plan(text)
    parse_term(text)


def _read_project(text: str, path: Path) -> None:
    for source in _SOURCES:
        path.with_name(source).touch()
    MultiAgentSystem.load(_written(path.with_suffix(".mas2j"), text))


def _read_formula(text: str, _: Path) -> None:
    compile_formula(parse_formula(text, VOCABULARY))


def _read_requirements(text: str, path: Path) -> None:
    for requirement in load_requirements(_written(path, text), VOCABULARY):
        compile_formula(requirement.formula, requirement.names)


def _read_gate(text: str, _: Path) -> None:
    with contextlib.suppress(ThresholdError):
        parse_threshold(text)
    with contextlib.suppress(ExemptionError):
        parse_exemption(text, ALLOWED_UNTRIGGERED)
    exemption = parse_exemption(text, KNOWN)
    if exemption.condition:
        with contextlib.suppress(RequirementError):
            compile_condition(parse_condition(exemption.condition, VOCABULARY))


def draw(target: Target, rng: Random) -> str:
    """An input: mostly a seed with a few changes."""
    from benchmarks.fuzz.mutation import mutate_json, mutate_text

    seed = rng.choice(target.seeds)
    if target.is_json and rng.random() < 0.8:
        return mutate_json(seed, rng)
    return mutate_text(seed, target.seeds, rng)
