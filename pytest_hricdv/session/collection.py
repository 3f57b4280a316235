"""`Collection`: turns every generated test into a pytest item, and holds the session's options, testbench and suites.

`plugin` registers it as a pytest plugin in every process of a session with a suite or a replay. With xdist, the
controlling process sends the suites to each worker under the keys below, and the worker reads them by `worker_input`.
"""

from __future__ import annotations

import glob
import re
import shutil
import textwrap
import time
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cached_property

import pytest

from pytest_hricdv._base import own_json as json
from pytest_hricdv._base.hash_seed import own_hash_seed
from pytest_hricdv._base.message import visible
from pytest_hricdv._base.process_state import Finders, complaint, hide_arguments
from pytest_hricdv._base.self_check import library_conflict
from pytest_hricdv.execution.hri_case import HriCase
from pytest_hricdv.report.formatting import fit_list
from pytest_hricdv.results.report_builder import GeneratedSuite
from pytest_hricdv.runtime.virtual.prohibition import keep_builtins
from pytest_hricdv.session import replaying
from pytest_hricdv.session.following import base_imports
from pytest_hricdv.session.option import feature_options, locate_error, usage_error
from pytest_hricdv.session.options import SESSION_DAY, Options
from pytest_hricdv.session.replaying import ReplayInput
from pytest_hricdv.session.suites import cases, from_text, select_suites, to_text
from pytest_hricdv.session.testbench_search import on_installed_engine
from pytest_hricdv.testbench import Testbench, TestbenchError
from pytest_hricdv.testbench_faults import check_testbench, describe_keywords

ATTRIBUTE = "hricdv"
"""The attribute of pytest's `TestReport` for a test's call that holds the `TestResult`, as JSON."""

WORKER_INPUT = "hricdv_suites"
ONLY_CASES = "hricdv_only_cases"
REPLAYS = "hricdv_replays"
WORKER_HASH_SEED = "hricdv_hash_seed"
"""A key of what a worker sends at its end; the keys above are of what it receives."""
DONE = "hricdv_done"
"""A key of what a worker receives: the tests that an earlier session has finished."""
ALONE = "hricdv_alone"
"""A key for a process started for certain tests: it runs them itself instead of starting more processes."""
_NAMED = re.compile(r"::[^\[]*\[.*?(?P<id>[A-Za-z0-9_]+(?:-[A-Za-z0-9_]+)*-[0-9a-f]{8}(?:[0-9a-f]{8})?(?:-k\d+)?)\b")

_LONG_S, _TELL_AGAIN_S = 2.0, 60.0
"""A step that takes longer than the first is announced; a log repeats this at the second interval (s of wall time)."""


def worker_input(config: pytest.Config) -> dict[str, object] | None:
    """The input from xdist's controller to this worker; None in the controller, or without xdist."""
    values: dict[str, object] | None = getattr(config, "workerinput", None)
    return values


def case_of(item: pytest.Item) -> HriCase | None:
    """The generated test behind an item; None for any other item."""
    callspec = getattr(item, "callspec", None)
    case = callspec.params.get("hri_case") if callspec is not None else None
    return case if isinstance(case, HriCase) else None


class Collection:
    """Testbench and suites of the session; parametrizes `hri_case` with the tests of the suites."""

    def __init__(self, config: pytest.Config, options: Options) -> None:
        self.config = config
        self.options = options
        self.generate_further: Callable[[Sequence[GeneratedSuite]], Iterable[GeneratedSuite]] = lambda suites: ()
        """Generates the suites of optional features, given the others; set in the controlling process."""
        sent = worker_input(config) or {}  # without a suite, a worker is sent nothing
        self.done: frozenset[str] = frozenset(json.loads(str(sent.get(DONE, "[]"))))
        """Node ids of tests that are not run again, in a session that is resumed."""
        self._is_rewriting = False
        """The cursor is on a line that is rewritten."""
        self._is_unasked = False
        """No test asks for a generated one."""
        self._loaded = 0
        """How many implementations of the testbench's hook there were when it was called."""

    @cached_property
    def testbench(self) -> Testbench:
        """The project's testbench. Raises pytest.UsageError, located, when there is none or it lacks a part."""
        hook = self.config.hook.pytest_hricdv_testbench
        implementations = hook.get_hookimpls()
        if not implementations:
            raise usage_error(
                f"no testbench: implement pytest_hricdv_testbench(config) in {self.config.rootpath / 'conftest.py'} "
                "and return a pytest_hricdv.testbench.Testbench"
            )
        self._loaded = len(implementations)
        code, finders = implementations[-1].function.__code__, Finders()
        try:
            with base_imports(self.config, implementations[-1].function.__module__), keep_builtins(), hide_arguments():
                made = hook(config=self.config)
            if lost := (*finders.put_back(),):
                raise TestbenchError(complaint(lost, getattr(made, "code", ())))
            if conflict := library_conflict():  # by a file that it has written
                raise TestbenchError(conflict)
            testbench = check_testbench(made, f"{code.co_filename}:{code.co_firstlineno}: {code.co_name}")
            testbench = testbench.choose(fidelity=self.options.fidelity) if self.options.fidelity else testbench
            testbench = on_installed_engine(testbench)
            for feature in feature_options():
                testbench = feature.configure(testbench, self.options)
            return testbench
        except TestbenchError as error:
            raise usage_error(str(error)) from None
        except (Exception, SystemExit) as error:  # a module of the code under test may exit where it is imported
            raise usage_error(f"{locate_error(error)}{describe_keywords(error)}") from error

    @cached_property
    def suites(self) -> list[GeneratedSuite]:
        """The suites; generated at most once in a session, and never in a worker."""
        sent = worker_input(self.config)
        if sent is not None:
            return from_text(str(sent[WORKER_INPUT]))
        if self.options.replay:
            return replaying.suites(self.replays.values(), self.testbench)
        cache = getattr(self.config, "cache", None)
        root = self.config.invocation_params.dir
        suites = select_suites(self.options, root, self.testbench, cache, self.say, self.wait)
        return [*suites, *self.generate_further(suites)]

    @cached_property
    def replays(self) -> dict[str, ReplayInput]:
        """Test id -> its replay file; empty if nothing is replayed."""
        sent = worker_input(self.config)
        if sent is not None:
            files = replaying.from_text(str(sent[REPLAYS]))
        else:
            files = replaying.read_replays(self.options.replay, self.testbench, self.config.invocation_params.dir)
        return {file.replay.test.id: file for file in files}

    @cached_property
    def cases(self) -> list[HriCase]:
        """The cases of the session, in order: all, or those of its shard."""
        part = self.options.shard
        return [case for case in self.all_cases if part is None or case.abstract.id in part]

    @cached_property
    def all_cases(self) -> list[HriCase]:
        """All cases of the suites, in order."""
        if not self.replays:
            return cases(self.suites, self.testbench, self.options.concretizations, self.options.sampling)
        replayed = cases(self.suites, self.testbench, 1)
        for case in replayed:
            case.fixed = self.replays[case.abstract.id].replay.concrete
        return replayed

    @cached_property
    def only_cases(self) -> bool:
        """Whether only generated tests are collected: a suite is named on the command line, and no paths are."""
        sent = worker_input(self.config)
        if sent is not None:
            return bool(sent.get(ONLY_CASES))  # nothing was sent where there is no testbench
        paths_named = self.config.args_source == pytest.Config.ArgsSource.ARGS
        return self.options.suite_named and not paths_named

    def limit_paths(self) -> None:
        """Collect only the paths of `hri_testpaths`, where only generated tests are wanted and the key is set.

        Other test files then need not be importable: they may import packages that are not installed. It also saves
        the time to import them. Call it in `pytest_configure`.
        """
        if self.only_cases:
            self.config.args = _host_paths(self.config) or self.config.args

    def say(self, text: str) -> None:
        """Report progress of what takes long."""
        reporter = self.config.pluginmanager.get_plugin("terminalreporter")
        if reporter is not None and self.config.get_verbosity() >= 0:
            if self._is_rewriting:
                reporter.rewrite("", erase=True)
                reporter.write("\r", flush=True)
                self._is_rewriting = False
            else:
                self._end_line(reporter)
            line, columns = visible(text), shutil.get_terminal_size().columns - 1
            if reporter.isatty and len(line) > columns:  # between words, which the terminal would break
                line = textwrap.fill(line, columns, subsequent_indent="  ", break_long_words=False)
            reporter.write_line(line)

    def _end_line(self, reporter: pytest.TerminalReporter) -> None:
        """End the line that pytest has begun, also where it does not know: with xdist, it writes dots to no file."""
        reporter.ensure_newline()
        writer = self.config.get_terminal_writer()
        if writer.width_of_current_line:
            writer.line()

    def wait(self, what: str) -> Callable[[str], None]:
        """A callback for progress, which is shown after two seconds, in a log once a minute."""
        began = told = time.monotonic()

        def tell(how_far: str) -> None:
            nonlocal told
            now = time.monotonic()
            if now - began < _LONG_S:
                return
            text = f"hricdv: {what}: {how_far}"
            if not self.rewrite([text]) and (told == began or now - told >= _TELL_AGAIN_S):
                told = now
                self.say(text)

        return tell

    def rewrite(self, texts: Iterable[str]) -> bool:
        """Report progress on a line that the next report takes; False if there is no terminal, or none is wanted.

        Args:
            texts: that say it, the fullest first; the first that fits is shown. Of a line that wraps, the terminal
                would keep a part.
        """
        reporter = self.config.pluginmanager.get_plugin("terminalreporter")
        if reporter is None or not reporter.isatty or self.config.get_verbosity() < 0:
            return False
        if not self._is_rewriting:
            self._end_line(reporter)
        reporter.rewrite(fit_list(map(visible, texts), shutil.get_terminal_size().columns - 1), erase=True)
        self._is_rewriting = True
        return True

    def pytest_generate_tests(self, metafunc: pytest.Metafunc) -> None:
        """Parametrizes `hri_case`, so that fixtures, -k, --lf and IDEs work as with any parametrized test."""
        if "hri_case" in metafunc.fixturenames:
            metafunc.parametrize("hri_case", self.cases, ids=[case.abstract.id for case in self.cases])

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_collection_modifyitems(self, config: pytest.Config, items: list[pytest.Item]) -> Iterator[None]:
        """Deselects items that are not generated tests, before -k and --lf select among the others."""
        if self.only_cases:
            others = [item for item in items if case_of(item) is None]
            self._is_unasked = len(others) == len(items) and bool(self.cases)
            if others:
                config.hook.pytest_deselected(items=others)
                items[:] = [item for item in items if case_of(item) is not None]
        yield

    def pytest_sessionstart(self) -> None:
        """xdist: a worker says which hash seed it has, and has its testbench before it collects, as others do."""
        if WORKER_INPUT in (worker_input(self.config) or {}):
            _ = self.testbench  # conftest files of further folders, which are loaded now, may have another one
        said: dict[str, object] = getattr(self.config, "workeroutput", {})
        said[WORKER_HASH_SEED] = own_hash_seed()

    def pytest_collection_finish(self) -> None:
        """Warns of a testbench that was loaded while pytest collected: the session had another one by then.

        And of a session whose tests no test function asks for, as where it is called otherwise than pytest wants.
        """
        if self._is_unasked:
            number, suites = len(self.cases), self.options.suites
            text = (
                f"no test function has hri_case as an argument, so the {number} tests of {suites} are not run: "
                "expected one as `def test_robot(hri_case): hri_case.check(hri_case.run())`, where pytest "
                "collects tests, and in no unittest.TestCase"
            )
            self.warn(text, str(self.config.inipath or self.config.rootpath), 1)
        implementations = self.config.hook.pytest_hricdv_testbench.get_hookimpls()
        codes = [implementation.function.__code__ for implementation in implementations]
        for code in codes[self._loaded :] if self._loaded else ():
            used = codes[self._loaded - 1].co_filename
            text = f"this testbench is not used, as the session has that of {used}: name the folder of its tests alone"
            self.warn(text, code.co_filename, code.co_firstlineno)

    def warn(self, text: str, file: str, line: int) -> None:
        """Not with `warnings.warn`: where warnings are errors, it would end the session in a traceback."""
        message = warnings.WarningMessage(pytest.PytestWarning(text), pytest.PytestWarning, file, line)
        self.config.hook.pytest_warning_recorded.call_historic(
            kwargs={"warning_message": message, "nodeid": "", "when": "collect", "location": None}
        )

    @pytest.hookimpl(optionalhook=True)
    def pytest_configure_node(self, node: object) -> None:
        """xdist: sends the suites to a worker that starts; workers do not generate."""
        values: dict[str, object] = node.workerinput  # type: ignore[attr-defined]
        values.update(self.worker_values(), **{ONLY_CASES: self.only_cases, DONE: json.dumps(sorted(self.done))})

    def worker_values(self) -> dict[str, object]:
        """The values passed to a process that does not generate; it also needs to know which tests are collected and
        done."""
        return {
            WORKER_INPUT: to_text(self.suites),
            ONLY_CASES: False,
            SESSION_DAY: self.options.today.isoformat(),
            DONE: "[]",
            REPLAYS: replaying.to_text(self.replays.values()),
        }


def explain_missing_items(arguments: Sequence[str], options: Options | None) -> str:
    """Explains why pytest did not find generated tests that the command line names; empty when it names none.

    Args:
        arguments: paths and node ids of the command line.
        options: the options in force; None if no suite is active.
    """
    named = [match["id"] for argument in arguments if (match := _NAMED.search(argument))]
    if not named:
        return ""
    if options is None:
        return (
            f"\n{named[0]} is the id of a generated test, and no suite is active: give the --hri-suite that it is of, "
            "or set hri_suite in the ini file, so that IDEs find it, too"
        )
    if options.replay:
        return f"\n{named[0]} is the id of a generated test, and --hri-replay has the tests of its files only"
    return (
        f"\n{named[0]} is the id of a generated test, and is not among those of --hri-suite={options.suites} "
        f"--hri-seed={options.seed}: which tests there are depends on suite, seed, --hri-tests, --hri-concretizations, "
        "and on models and belief space"
    )


def _host_paths(config: pytest.Config) -> list[str]:
    """The files and folders that `hri_testpaths` names, relative to the folder of the ini file; globs are expanded.

    Raises:
        pytest.UsageError: there is nothing of that name.
    """
    paths = []
    for pattern in config.getini("hri_testpaths"):
        matches = sorted(glob.glob(str(pattern), recursive=True))
        if not matches:
            raise usage_error(f"{config.inipath}: hri_testpaths: no such file or folder: {pattern}")
        paths += matches
    return paths
