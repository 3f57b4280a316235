"""The suites of a session: `Collection` gets them from `select_suites`, and sends them to xdist workers as text."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

from pytest_hricdv._base import own_json as json
from pytest_hricdv._base import sealed_cache
from pytest_hricdv._base.atomic_file import write_text
from pytest_hricdv.execution.hri_case import HriCase
from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.concrete import UNIFORM, check_values, expand
from pytest_hricdv.generate.context import GenerationContext, Method
from pytest_hricdv.generate.methods import ALL, ByHand, select_methods
from pytest_hricdv.generate.suite import Suite
from pytest_hricdv.generate.suite_files import Files, dump_tests
from pytest_hricdv.results.report_builder import GeneratedSuite
from pytest_hricdv.session.learning_options import METHOD, parameters, warm_start
from pytest_hricdv.session.option import feature_suites, usage_error
from pytest_hricdv.session.options import MAX_TESTS, Options
from pytest_hricdv.testbench import Testbench

CACHE_FOLDER = "hricdv"
"""The folder in pytest's cache that keeps generated suites."""


def _method_suites(suites: str) -> str:
    """The selected suites, except those that optional features generate from the others."""
    names = [name.strip() for name in suites.split(",")]
    of_parts = feature_suites()
    return ",".join(name for name in names if name not in of_parts) if of_parts.intersection(names) else suites


def select_suites(
    options: Options,
    root: Path,
    testbench: Testbench,
    cache: Any | None,
    say: Callable[[str], None],
    wait: Callable[[str], Callable[[str], None]],
) -> list[GeneratedSuite]:
    """Generate, or take from the cache, every suite that was asked for.

    Args:
        root: the folder that paths of suites are relative to.
        cache: `config.cache`, or None if the cache plugin is off.
        say: receives messages.
        wait: receives the title of a step that may take long; returns a function that receives its progress.

    Raises:
        pytest.UsageError: an unknown suite, a missing path, a model or a file that is wrong, or two equal names.
    """
    try:
        of_methods = _method_suites(options.suites)
        methods = _methods(of_methods, root, testbench, say) if of_methods else ()
        context = _context(options, testbench, learns=any(method.name == METHOD for method in methods))
        reading = replace(context, commands=tuple(testbench.commands.commands))  # methods draw no disturbances
        selected = [
            _generate(method, reading if isinstance(method, Files) else context, cache, wait) for method in methods
        ]
    except GenerateError as error:
        raise usage_error(f"--hri-suite: {error}") from None
    total = options.concretizations * sum(len(generated.suite.tests) for generated in selected)
    if total > MAX_TESTS:
        count = f"{total:,} tests, {options.concretizations} of each abstract test"
        raise usage_error(f"--hri-concretizations: {count}; expected at most {MAX_TESTS:,} in a session")
    names = [generated.suite.name for generated in selected]
    for name in names:
        if names.count(name) > 1:
            raise usage_error(f"--hri-suite: two suites have the name {name!r}; rename a file or folder")
    for method, generated in zip(methods, selected, strict=True):
        check_commands(generated.suite, testbench)
        _check_values(generated.suite, testbench, f"{method.path}: " if isinstance(method, Files) else "")
    return selected


def _methods(selection: str, root: Path, testbench: Testbench, say: Callable[[str], None]) -> tuple[Method, ...]:
    """The selected methods; `all` stands for those that the testbench supports, and reports the others."""
    lacking = [ByHand.name] if testbench.suites.by_hand is None else []
    methods = select_methods(selection, root, lacking)
    if ALL in selection.split(",") and lacking and lacking[0] not in {method.name for method in methods}:
        say(f"hricdv: suite all is without {lacking[0]}: the testbench names no file of belief subsets (by_hand)")
    return methods


def generation_context(options: Options, testbench: Testbench) -> GenerationContext:
    """The inputs of generation, without those of learning."""
    return GenerationContext(
        model=testbench.model,
        space=testbench.beliefs,
        commands=tuple(testbench.concretization.commands),
        seed=options.seed,
        tests=options.tests,
        by_hand=testbench.suites.by_hand,
        lengths=testbench.suites.random_test_length,
    )


def _context(options: Options, testbench: Testbench, *, learns: bool) -> GenerationContext:
    """The inputs of generation."""
    if options.learning.named and not learns:
        raise usage_error(f"{options.learning.named[0]}: nothing is learned; select the suite {METHOD}")
    context = generation_context(options, testbench)
    if not learns:
        return context
    return replace(
        context,
        learning=parameters(options.learning, testbench),
        start=warm_start(options.learning, testbench),
        save=options.learning.save,
    )


def _generate(
    method: Method, context: GenerationContext, cache: Any | None, wait: Callable[[str], Callable[[str], None]]
) -> GeneratedSuite:
    if isinstance(method, Files):  # reading files is as quick as reading the cache
        return GeneratedSuite(method.generate(context), 0.0, cached=False)
    if isinstance(method, ByHand) and method.path is not None:
        context = replace(context, by_hand=method.path)
    key = f"{CACHE_FOLDER}/{context.fingerprint(method.name)}"
    text = sealed_cache.read(cache, key)
    learned_anew = method.name == METHOD and context.save is not None  # the cache keeps suites, not tables
    if isinstance(text, str) and not learned_anew:
        try:
            return GeneratedSuite(Suite.from_json(text), 0.0, cached=True)
        except GenerateError:
            pass  # written by another version, or cut off: generate again
    context = replace(context, tell=wait(f"generating suite {method.name} (seed {context.seed})"))
    began = time.perf_counter()
    suite = method.generate(context)
    wall_s = time.perf_counter() - began
    sealed_cache.write(cache, key, suite.to_json())
    return GeneratedSuite(suite, wall_s, cached=False)


def check_commands(suite: Suite, testbench: Testbench) -> None:
    """Raise pytest.UsageError for a test with a command that the testbench does not know."""
    declared = testbench.commands.commands
    for test in suite.tests:
        for line in test.lines:
            if line not in declared:
                commands = ", ".join(declared)
                raise usage_error(f"suite {suite.name}, test {test.id}: unknown command {line!r}; known: {commands}")


def _check_values(suite: Suite, testbench: Testbench, file: str) -> None:
    for test in suite.tests:
        try:
            check_values(test, testbench.commands)
        except GenerateError as error:
            raise usage_error(f"{file}suite {suite.name}, {error}") from None


def cases(
    selected: Iterable[GeneratedSuite], testbench: Testbench, concretizations: int, sampling: str = UNIFORM
) -> list[HriCase]:
    """One case for each concrete test."""
    ranges = testbench.commands
    return [
        HriCase(generated.suite.name, test, ranges, sampling)
        for generated in selected
        for test in expand(generated.suite.tests, concretizations, sampling)
    ]


def to_text(selected: Iterable[GeneratedSuite]) -> str:
    """The suites as text for xdist's `workerinput`."""
    return json.dumps([[generated.suite.to_json(), generated.wall_s, generated.cached] for generated in selected])


def from_text(text: str) -> list[GeneratedSuite]:
    """The suites that `to_text` wrote."""
    return [GeneratedSuite(Suite.from_json(suite), wall_s, cached) for suite, wall_s, cached in json.loads(text)]


def export(selected: Iterable[GeneratedSuite], folder: Path) -> list[Path]:
    """Write each suite as a text file that `--hri-suite=FOLDER` reads back with its ids unchanged.

    Raises pytest.UsageError if the folder cannot be written.
    """
    try:
        suites = [generated.suite for generated in selected]
        return [write_text(folder / f"{suite.name}.txt", dump_tests(suite.tests)) for suite in suites]
    except OSError as error:
        raise usage_error(f"--hri-export={folder}: {error.strerror or error}; choose another folder") from None
