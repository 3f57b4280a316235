"""`ImportWatch` follows imports: which module imports which, and what each covers while it is first imported.

`ImportCoverage` has one. A module runs once in a process, at its first import: in a test, or before all tests. Its
coverage belongs to every test that imports it. It is measured during that import: importing a module again only to
measure it would run it again, which is dangerous next to hardware. A module that nothing imports is never run.
"""

from __future__ import annotations

import builtins
import importlib
import os.path
import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from functools import cache
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from pathlib import Path
from threading import get_ident
from types import ModuleType
from typing import Any

from pytest_hricdv._base.error_text import causes

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too

Measuring = Callable[[str], AbstractContextManager[None]]
"""Measures what the module with this name runs while it is imported."""


class ImportWatch(MetaPathFinder):
    """Observes the imports of a process from its installation on.

    Args:
        is_of_interest: whether a module that is loaded from this file is followed.
    """

    def __init__(self, is_of_interest: Callable[[Path], bool], measuring: Measuring) -> None:
        self.is_of_interest = is_of_interest
        self._measuring = measuring
        self.files: dict[str, Path] = {}
        """The modules that were followed -> their files, in the order in which their imports began."""
        self.failures: dict[str, BaseException] = {}
        """Modules whose import raised -> the exception."""
        self._needs: dict[str, set[str]] = {}
        self._asking: list[set[str]] = []
        self._finding: set[tuple[int, str]] = set()

    def install(self) -> None:
        """Follow imports from now on."""
        sys.meta_path.insert(0, self)

    def uninstall(self) -> None:
        """Follow them no longer."""
        if self in sys.meta_path:
            sys.meta_path.remove(self)

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """See `importlib.abc.MetaPathFinder`; None for every module that is not followed."""
        asked = get_ident(), fullname
        if asked in self._finding:  # another finder asks all of them
            return None
        self._finding.add(asked)
        try:
            specs = (finder.find_spec(fullname, path, target) for finder in self._others())
            spec: ModuleSpec | None = next(filter(None, specs), None)
        finally:
            self._finding.discard(asked)
        if spec is None or spec.loader is None or not hasattr(spec.loader, "exec_module"):
            return None
        file = file_of(spec)
        if file is None or not self.is_of_interest(file):
            return spec
        spec.loader = _LoaderProxy(spec.loader, lambda: self._follow(fullname, file))
        return spec

    def _others(self) -> Iterable[Any]:
        return [finder for finder in sys.meta_path if finder is not self and hasattr(finder, "find_spec")]

    @contextmanager
    def _follow(self, name: str, file: Path) -> Iterator[None]:
        self.files.setdefault(name, file)
        self.failures.pop(name, None)
        if self._asking:
            self._asking[-1].add(name)  # it may be imported by no statement, as by an import hook
        with self.note_imports() as needs:
            self._needs[name] = needs
            try:
                with self._measuring(name):
                    yield
            except BaseException as error:
                self.failures[name] = error
                raise

    @contextmanager
    def note_imports(self) -> Iterator[set[str]]:
        """Collects the names of modules that are imported meanwhile, whether loaded before or not."""
        names: set[str] = set()
        is_outermost = not self._asking
        self._asking.append(names)
        try:
            with self._note() if is_outermost else nullcontext():
                yield names
        finally:
            self._asking[:] = [others for others in self._asking if others is not names]

    @contextmanager
    def _note(self) -> Iterator[None]:
        """Record what import statements and `importlib.import_module` ask for."""
        real_import, real_import_module = builtins.__import__, importlib.import_module
        importing, importing_module = self._wrap_import(real_import), self._wrap_import_module(real_import_module)
        builtins.__import__, importlib.import_module = importing, importing_module
        try:
            yield
        finally:  # somebody else may have put his own before it, and have left it there
            if builtins.__import__ is importing:
                builtins.__import__ = real_import
            if importlib.import_module is importing_module:
                importlib.import_module = real_import_module

    def _wrap_import_module(self, real_import_module: Callable[..., ModuleType]) -> Callable[..., ModuleType]:
        def import_module(name: str, package: str | None = None) -> ModuleType:
            __tracebackhide__ = True
            module = real_import_module(name, package)
            if self._asking:
                self._asking[-1].update(_with_parents(module.__name__))
            return module

        return import_module

    def _wrap_import(self, real_import: Callable[..., Any]) -> Callable[..., Any]:
        def import_statement(
            name: str, globals: Any = None, locals: Any = None, fromlist: Sequence[str] | None = (), level: int = 0
        ) -> Any:
            __tracebackhide__ = True
            if not self._asking:
                return real_import(name, globals, locals, fromlist or (), level)
            asking, wanted = self._asking[-1], _absolute(name, globals, level)
            asking.update(_with_parents(wanted))
            try:
                return real_import(name, globals, locals, fromlist or (), level)
            finally:
                parts = (f"{wanted}.{part}" for part in fromlist or ())
                asking.update(part for part in parts if part in sys.modules or part in self.files)

        return import_statement

    def close_over_imports(self, names: Iterable[str]) -> frozenset[str]:
        """The given modules that were followed, and all that they imported in turn."""
        needed: set[str] = set()
        waiting = list(names)
        while waiting:
            name = waiting.pop()
            if name in self.files and name not in needed:
                needed.add(name)
                waiting += self._needs[name]
                waiting += _with_parents(name)
        return frozenset(needed)

    def find_failure(self, error: BaseException) -> tuple[str, BaseException] | None:
        """The module whose import raised an error, or what this error came of, and what it raised; None if none did.

        Of several modules that import each other, the one that raised it itself.
        """
        chain = [*causes(error)]
        for name, failure in self.failures.items():  # inner ones first
            if any(failure is link for link in chain):
                return name, failure
        return None

    def of_files(self, files: Collection[Path]) -> list[str]:
        """The followed modules that are loaded from these files."""
        return [name for name, file in self.files.items() if file in files]


def file_of(spec: ModuleSpec) -> Path | None:
    """The file that a module is loaded from; None if there is none, as for what is built in."""
    return _resolve(os.path.abspath(spec.origin)) if spec.has_location and spec.origin is not None else None


@cache
def _resolve(origin: str) -> Path:
    """Without links; asked for a thousand loaded modules at each session's start, a tenth of a short session's time."""
    return Path(origin).resolve()


def _absolute(name: str, globals: Any, level: int) -> str:
    """The full name of what an import statement names, relative to the module with these names."""
    if not level:
        return name
    names = globals or {}
    package = names.get("__package__")
    if package is None:
        package = str(names.get("__name__", ""))
        package = package if "__path__" in names else package.rpartition(".")[0]
    parts = package.split(".")
    return ".".join(filter(None, (*parts[: len(parts) - level + 1], name)))


def _with_parents(name: str) -> list[str]:
    parts = name.split(".")
    return [".".join(parts[:length]) for length in range(1, len(parts) + 1)]


class _LoaderProxy(Loader):
    """Wraps another loader, which the module refers to from its first line on, to follow the import."""

    def __init__(self, loader: Any, following: Callable[[], AbstractContextManager[None]]) -> None:
        self._loader = loader
        self._follow = following

    def __getattr__(self, name: str) -> Any:
        return getattr(self._loader, name)

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        """See `importlib.abc.Loader`."""
        create = getattr(self._loader, "create_module", None)
        return None if create is None else create(spec)

    def exec_module(self, module: ModuleType) -> None:
        """See `importlib.abc.Loader`."""
        __tracebackhide__ = True
        module.__loader__ = self._loader
        if module.__spec__ is not None:
            module.__spec__.loader = self._loader
        with self._follow():
            self._loader.exec_module(module)
