"""The pytest plugin: hooks that add options and register the objects of `session`; fixtures `hri_case` and `hri_run`.

pytest loads this module in every session, so it imports nothing heavy unless a suite is active.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from pytest_hricdv.custom_tests import HriCase, HriRun
    from pytest_hricdv.session.options import Options
    from pytest_hricdv.session.run_context import RunContext

NO_SUITE = "no suite is active: choose one with --hri-suite=NAME|PATH, or with hri_suite in the ini file"


def pytest_addoption(parser: pytest.Parser) -> None:
    """Registers options and ini keys."""
    try:
        from pytest_hricdv.session.option_table import add_options
    except ImportError:
        from pytest_hricdv._base.self_check import library_conflict

        if conflict := library_conflict():
            raise pytest.UsageError(conflict) from None
        raise
    add_options(parser)


def pytest_addhooks(pluginmanager: pytest.PytestPluginManager) -> None:
    """Registers the hook that returns the testbench."""
    from pytest_hricdv import hooks

    pluginmanager.add_hookspecs(hooks)


def pytest_load_initial_conftests(early_config: pytest.Config, args: list[str]) -> None:
    """Adapts the values of TOML files; follows imports from before the conftests on, where tests are measured; explains
    `-n` without xdist: pytest only reports an unrecognized argument.
    """
    from pytest_hricdv._base.descriptors import keep_open
    from pytest_hricdv._base.self_check import library_conflict
    from pytest_hricdv.session import following  # it is light
    from pytest_hricdv.session.option_table import adapt, refuse_typos

    refuse_typos(early_config, args)
    adapt(early_config)
    keep_open()
    if following.is_wanted(early_config, args):
        if conflict := library_conflict():  # before a conftest imports the testbench
            raise pytest.UsageError(conflict)
        following.follow_imports(early_config)
    if hasattr(early_config.known_args_namespace, "numprocesses"):  # whatever name xdist was loaded by
        return
    asked = any(
        arg == "-n" or arg.startswith(("-n=", "--numprocesses")) or (arg[:2] == "-n" and arg[2:].isdigit())
        for arg in args
    )
    if asked and (early_config.getini("hri_suite") or any(arg.startswith("--hri-") for arg in args)):
        raise pytest.UsageError(
            "-n needs pytest-xdist, which is not installed or switched off: pip install pytest-xdist"
        )


def pytest_configure(config: pytest.Config) -> None:
    """Registers the plugin's objects, and only when a suite is active."""
    from pytest_hricdv.session.option_table import refuse_unknown_kinds
    from pytest_hricdv.session.options import read_options

    refuse_unknown_kinds(config)
    options = read_options(config)
    if options.suites or options.replay:
        _register(config, options)


@pytest.hookimpl(tryfirst=True)
def pytest_cmdline_main(config: pytest.Config) -> None:
    """Refuses what would run for ever, before xdist begins with it."""
    if config.getoption("looponfail", False):
        from pytest_hricdv.session.options import read_options
        from pytest_hricdv.session.pytest_options import refuse_looponfail

        options = read_options(config)
        if options.suites or options.replay:
            refuse_looponfail(config, options)


def _register(config: pytest.Config, options: Options) -> None:
    from pytest_hricdv._base.grammar import LarkError, require_lark
    from pytest_hricdv._base.self_check import library_conflict
    from pytest_hricdv.session import pytest_options
    from pytest_hricdv.session.collection import ALONE, Collection, worker_input
    from pytest_hricdv.session.exports import attachers
    from pytest_hricdv.session.following import follow_imports, follow_no_longer
    from pytest_hricdv.session.option import usage_error
    from pytest_hricdv.session.pytest_options import FirstLines
    from pytest_hricdv.session.resuming import ResumeFilter
    from pytest_hricdv.session.run_context import CONTEXT, RunContext
    from pytest_hricdv.session.running import TestRunner
    from pytest_hricdv.session.testbench_search import WithoutTestbench, has_testbench

    try:
        require_lark()
    except LarkError as error:
        raise usage_error(str(error)) from None
    if conflict := library_conflict():
        raise usage_error(conflict)
    pytest_options.refuse_break(config, options)
    collection = Collection(config, options)
    collection.limit_paths()
    if not (has_testbench(config) or options.suite_named):
        is_worker = worker_input(config) is not None
        without = WithoutTestbench(config, options.suites, is_worker=is_worker)
        config.pluginmanager.register(without, "hricdv-without-testbench")
        return
    if options.coverage:
        imports = follow_imports(config)
        imports.base.update(imports.watch.files)  # by the conftests, which tests may use as they are
    else:
        follow_no_longer(config)
    context = config.stash[CONTEXT] = RunContext(collection)
    config.pluginmanager.register(collection, "hricdv-collection")
    config.pluginmanager.register(TestRunner(context), "hricdv-running")
    config.pluginmanager.register(FirstLines(), FirstLines.NAME)
    config.pluginmanager.register(ResumeFilter(collection), "hricdv-passing-over")
    if not config.pluginmanager.hasplugin("skipping"):
        config.pluginmanager.register(pytest_options.ExpectedFailures(), "hricdv-expected-failures")
    for attachment in attachers(collection):
        config.pluginmanager.register(attachment)
    if worker_input(config) is None:
        _register_in_controller(config, context, options)
    else:
        from pytest_hricdv.session.signals import end_with_parent

        end_with_parent()
    if options.isolate and ALONE not in (worker_input(config) or {}):
        from pytest_hricdv.session.isolation import Isolation

        config.pluginmanager.register(Isolation(context), "hricdv-isolation")  # the last one, so that it is outside


def _register_in_controller(config: pytest.Config, context: RunContext, options: Options) -> None:
    from pytest_hricdv.session.aggregation import Aggregation
    from pytest_hricdv.session.early_end import EarlyEnd
    from pytest_hricdv.session.exports import Exporter, read_targets
    from pytest_hricdv.session.feature import features
    from pytest_hricdv.session.preparation import GateCheck, Preparation
    from pytest_hricdv.session.progress import Progress
    from pytest_hricdv.session.reporting import SessionReporter
    from pytest_hricdv.session.terminal_summary import ShownFailures, SummarySection

    collection = context.collection
    collection.generate_further = lambda suites: [
        suite for feature in features() for suite in feature.generate(context, suites)
    ]
    gate_check = GateCheck(collection)
    aggregation = Aggregation(collection, context)
    config.pluginmanager.register(EarlyEnd(context, aggregation), "hricdv-early-end")
    reporting = SessionReporter(collection, context, aggregation, gate_check)
    preparation = Preparation(collection, context, gate_check, aggregation)
    config.pluginmanager.register(preparation, "hricdv-preparation")
    config.pluginmanager.register(aggregation, "hricdv-aggregation")
    config.pluginmanager.register(aggregation.journaling, "hricdv-journaling")
    config.pluginmanager.register(reporting, "hricdv-reporting")
    failures = ShownFailures(aggregation, lambda: reporting.report)
    config.pluginmanager.register(failures, "hricdv-shown-failures")
    config.pluginmanager.register(SummarySection(reporting, failures), "hricdv-summary-section")
    config.pluginmanager.register(Progress(config, aggregation.chosen), "hricdv-progress")
    config.pluginmanager.register(Exporter(config, reporting, read_targets(config)), "hricdv-exporting")


@pytest.hookimpl(wrapper=True)
def pytest_collection(session: pytest.Session) -> Iterator[None]:
    """Explains why pytest did not find a generated test that the command line names."""
    try:
        return (yield)
    except pytest.UsageError as error:
        from pytest_hricdv.session.collection import explain_missing_items
        from pytest_hricdv.session.options import read_options

        active = session.config.pluginmanager.hasplugin("hricdv-collection")
        more = explain_missing_items(session.config.args, read_options(session.config) if active else None)
        error.args = (*error.args[:-1], f"{error.args[-1]}{more}")
        raise


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Without a suite, a test that asks for `hri_case` is skipped; the reason says how to choose a suite."""
    generating = ("hricdv-collection", "hricdv-without-testbench")
    if "hri_case" in metafunc.fixturenames and not any(map(metafunc.config.pluginmanager.hasplugin, generating)):
        skip = pytest.mark.skip(reason=NO_SUITE)
        metafunc.parametrize("hri_case", [pytest.param(None, marks=skip)], ids=["no-suite"], indirect=True)


@pytest.fixture
def hri_case(request: pytest.FixtureRequest) -> HriCase:
    """One generated test: `hri_case.check(hri_case.run())` runs it, and fails where it violates a requirement.

    What has it as an argument, a test or a fixture that it uses, runs once for each test of the suites (--hri-suite).
    """
    # Where tests are generated, these are the fixture's value, and this is not called.
    if not request.config.pluginmanager.hasplugin("hricdv-collection"):
        pytest.skip(NO_SUITE)  # also where pytest's marks for it are switched off
    pytest.fail(
        f"{request.node.nodeid}: hri_case is asked for while the test runs, as by request.getfixturevalue, and tests "
        "are generated before that: make it an argument of the test or of a fixture that it uses, or mark the test "
        "with @pytest.mark.usefixtures('hri_case')",
        pytrace=False,
    )


@pytest.fixture
def hri_run(request: pytest.FixtureRequest) -> HriRun:
    """Runs an abstract test given as text, and returns its result: verdicts, outcome, record. Needs no suite."""
    from pytest_hricdv.custom_tests import hri_run

    return hri_run(request)
