"""Finds the conftest file with the testbench if pytest would load it too late, and a physics engine that is installed.

pytest loads the conftest files of the folders that it is started with, and all others while it collects. A testbench is
needed before: the controlling process of xdist never collects, and the header has the number of tests. So `plugin` asks
`has_testbench`, and registers `WithoutTestbench` if there is none yet. `Collection` calls `on_installed_engine`.
"""

from __future__ import annotations

import importlib
import os
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest

from pytest_hricdv.hooks import HOOK
from pytest_hricdv.session.option import locate_error, usage_error
from pytest_hricdv.testbench import Testbench


def on_installed_engine(testbench: Testbench) -> Testbench:
    """The testbench with its first physics engine that is installed.

    If none is installed, it is the first one: its import then fails with a message on what to install.
    """
    names = tuple(testbench.simulation.engines)
    if not names:
        return testbench
    installed = (name for name in names if _is_installed(testbench, name))
    return testbench.choose(engine=next(installed, names[0]))


def engines_not_installed(testbench: Testbench) -> tuple[str, ...]:
    """The engines before the one in use, in the testbench's order, that are not installed."""
    names, engine = tuple(testbench.simulation.engines), testbench.simulation.engine
    before = names[: names.index(engine)] if engine else ()
    return tuple(name for name in before if not _is_installed(testbench, name))


def engine_modules(testbench: Testbench) -> tuple[str, ...]:
    """The modules to import for the engine in use: one, or none."""
    engine = testbench.simulation.engine
    module = testbench.simulation.engines[engine] if engine else ""
    return (module,) if module else ()


def import_engine(testbench: Testbench) -> None:
    """Import the engine in use, if there is one. Raises pytest.UsageError, with what else there is."""
    name = testbench.simulation.engine
    try:
        for module in engine_modules(testbench):
            importlib.import_module(module)
    except ImportError as error:
        others = ", ".join(engine for engine in testbench.simulation.engines if engine != name)
        instead = f"; or choose another one with --hri-engine: {others}" if others else ""
        raise usage_error(f"engine {name!r}: {error}{instead}") from None


def _is_installed(testbench: Testbench, name: str) -> bool:
    return not testbench.simulation.engines[name] or find_spec(name) is not None


CONFTEST = "conftest.py"


def has_testbench(config: pytest.Config) -> bool:
    """Whether there is a testbench where pytest is going to collect; its conftest file is loaded.

    Raises:
        pytest.UsageError: there are several, or the file cannot be imported.
    """
    paths = [path for argument in config.args if (path := _path(config, argument)).exists()]
    for path in paths:
        _load(config, path)
    if _is_implemented(config):
        return True
    files = dict.fromkeys(file for path in paths if path.is_dir() for file in _conftests_with_hook(config, path))
    if len(files) > 1:
        names = ", ".join(os.path.relpath(file, config.invocation_params.dir) for file in files)
        raise usage_error(
            f"{len(files)} testbenches below the paths to collect: {names}; a session has one: name the folder of one"
        )
    for file in files:
        _load(config, file.parent)
    return _is_implemented(config)


def _is_implemented(config: pytest.Config) -> bool:
    return bool(getattr(config.hook, HOOK).get_hookimpls())


def _path(config: pytest.Config, argument: str) -> Path:
    return Path(os.path.abspath(config.invocation_params.dir / argument.partition("::")[0]))


def _load(config: pytest.Config, path: Path) -> None:
    """Load the conftest files of a path, and of the folders above, as pytest does for those on its command line."""
    load = getattr(config.pluginmanager, "_loadconftestmodules", None)
    if load is None:  # of another pytest: what it has loaded itself has to do
        return
    try:
        load(
            path,
            config.getoption("importmode"),
            config.rootpath,
            consider_namespace_packages=config.getini("consider_namespace_packages"),
        )
    except Exception as error:
        raise usage_error(locate_error(getattr(error, "cause", error))) from error


def _conftests_with_hook(config: pytest.Config, folder: Path) -> Iterator[Path]:
    """The conftest files below a folder that name the hook; folders that pytest would not collect are left out."""
    for place, folders, files in os.walk(folder):
        folders[:] = sorted(name for name in folders if not _is_ignored(config, Path(place, name)))
        file = Path(place, CONFTEST)
        if CONFTEST in files and not _is_ignored(config, file) and HOOK.encode() in file.read_bytes():
            yield file


def _is_ignored(config: pytest.Config, path: Path) -> bool:
    return bool(config.hook.pytest_ignore_collect(collection_path=path, config=config))


class WithoutTestbench:
    """Stands in where the ini file names suites, and nothing that is collected has a testbench: nothing is generated.

    Args:
        suites: the suites of the ini file.
        is_worker: whether this is an xdist worker.
    """

    def __init__(self, config: pytest.Config, suites: str, *, is_worker: bool) -> None:
        self._config = config
        self._suites = suites
        self._is_worker = is_worker
        self._asking = ""

    def pytest_report_header(self) -> str:
        """One line."""
        names = " ".join(self._config.args)
        return f"hri: no testbench in {names}: no tests are generated, although hri_suite is {self._suites}"

    def pytest_generate_tests(self, metafunc: pytest.Metafunc) -> None:
        """A test that asks for a generated test cannot be collected."""
        if "hri_case" not in metafunc.fixturenames:
            return
        self._asking = self._asking or metafunc.definition.nodeid
        metafunc.parametrize("hri_case", [])
        if self._is_worker:
            raise pytest.Collector.CollectError(self._message())

    def pytest_collection_finish(self) -> None:
        """Says so as for a suite that is named on the command line: at once, with status 4."""
        if self._asking and not self._is_worker:
            raise usage_error(self._message())

    def _message(self) -> str:
        implementations = getattr(self._config.hook, HOOK).get_hookimpls()
        if implementations:
            place = implementations[-1].function.__code__.co_filename
            return f"{self._asking}: the testbench of {place} was loaded too late: name its folder on the command line"
        return (
            f"{self._asking} asks for hri_case, and there is no testbench: implement {HOOK}(config) in a conftest.py "
            "in its folder or above, and return a pytest_hricdv.testbench.Testbench"
        )
