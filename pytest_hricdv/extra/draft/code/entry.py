"""Finds the entry of the code: the function, class or script that a test runs, with its ports.

`EntryFinder` scores the candidates; demos, tests and main programs show which methods are called in a loop.
"""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from pytest_hricdv._base.message import nearest
from pytest_hricdv.extra.draft.code.classes import form_of, methods_of
from pytest_hricdv.extra.draft.code.flow import Flow, last_name, parameter_names
from pytest_hricdv.extra.draft.code.ports import PortReader
from pytest_hricdv.extra.draft.code.sources import DraftError, Module, Scope, Sources, name_with_dots
from pytest_hricdv.extra.draft.code_model import SCRIPT, Entry

GUARDED, IMPORTED = 2.0, 10.0
"""Scores of a script as the entry, with its loop in `if __name__ ...` or unguarded, so that importing it runs it."""


def find_scripts(sources: Sources) -> Iterator[tuple[Entry, float]]:
    """The scripts among the modules, each with its score as the entry."""
    for module in sources.modules:
        free = [statement for statement in module.tree.body if not _is_guard(statement)]
        guarded = [statement for statement in module.tree.body if _is_guard(statement)]
        loop = _find_loop(free)
        if loop is not None:
            yield _entry(module, loop), IMPORTED
        elif (loop := _find_loop(guarded)) is not None or (loop := _find_last_call(module)) is not None:
            yield _entry(module, loop), GUARDED


def _entry(module: Module, node: ast.stmt) -> Entry:
    return Entry(module.name, SCRIPT, "", False, (), (), module.location(node))


def _is_guard(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.If) and "__name__" in ast.unparse(statement.test)


def _statements(body: Sequence[ast.stmt]) -> Iterator[ast.stmt]:
    """The statements that run when a body does, those in blocks as well."""
    for statement in body:
        yield statement
        if not isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            for name in ("body", "orelse", "finalbody"):
                yield from _statements(getattr(statement, name, []))


def _find_loop(body: Sequence[ast.stmt]) -> ast.stmt | None:
    return next((statement for statement in _statements(body) if isinstance(statement, ast.While)), None)


def _find_last_call(module: Module) -> ast.stmt | None:
    """The last statement, if it is a call: then the module is a program that lets a library work."""
    last = module.tree.body[-1] if module.tree.body and "." not in module.name else None  # others are imported
    return last if isinstance(last, ast.Expr) and isinstance(last.value, ast.Call) else None


_RUNS = ("run", "main", "work", "serve", "loop", "start", "spin")
"""Functions, and methods of a robot's class, that make it work, the likeliest first."""

_NO_ROBOTS = {"Protocol", "ABC", "Exception", "NamedTuple", "TypedDict"}
"""Bases of classes that are none."""


@dataclass(frozen=True)
class _Candidate:
    """Something that may be the entry: a function, or a class with its method, and how likely."""

    score: float
    scope: Scope
    method: Scope | None


class EntryFinder:
    """Finds the entry, and reads its ports."""

    def __init__(self, sources: Sources, flow: Flow, used: Collection[str] = ()) -> None:
        self._sources, self._flow, self._used = sources, flow, used
        self._ports = PortReader(sources, flow)
        self._scripts = tuple(find_scripts(sources))

    def entry(self, name: str) -> Entry | None:
        """The entry; None if there is nothing to call.

        Args:
            name: the name of a function, class, or `Class.method`, or `SCRIPT`; empty for the likeliest one.

        Raises:
            DraftError: there is no such function.
        """
        if name == SCRIPT and self._scripts:
            return replace(self._scripts[0][0], is_certain=True)
        if name:
            return replace(self._read(self._find(name)), is_certain=True)
        return next((entry for entry, score in self.entries() if score > 0), None)

    def entries(self) -> Iterator[tuple[Entry, float]]:
        """All candidates for the entry, each with its score, the likeliest first."""
        made = [(score, entry.module, partial(replace, entry)) for entry, score in self._scripts]
        made += [(one.score, one.scope.module.name, partial(self._read, one)) for one in self._candidates()]
        asked = [rated for rated in made if rated[1] == self._sources.asked]
        made = asked if any(score > 0 for score, _, _ in asked) else made
        made.sort(key=lambda rated: -rated[0])
        for score, _, make in made:
            yield replace(make(), is_certain=len(made) == 1 or score >= made[1][0] + 2), score

    def _find(self, name: str) -> _Candidate:
        head, _, method = name.partition(".")
        scopes = [s for s in (*self._sources.functions, *self._sources.classes) if s.owner is None]
        scope = next((scope for scope in scopes if scope.node.name == head), None)
        asked = f"--from={self._sources.package}:{name}"
        if scope is None:
            near = nearest(head, [scope.node.name for scope in scopes])
            raise DraftError(f"{asked}: no function or class {head!r}{near}")
        if not isinstance(scope.node, ast.ClassDef):
            return _Candidate(0.0, scope, None)
        methods = methods_of(self._sources, scope)
        if method and method not in methods:
            raise DraftError(f"{asked}: {head} has no method {method!r}{nearest(method, methods)}")
        return _Candidate(0.0, scope, methods.get(method or _run_method(methods)))

    def _candidates(self) -> Iterator[_Candidate]:
        """Functions and classes; what gets a bus or a queue is likely, and so is what nothing of the code calls."""
        for scope in self._sources.functions:
            is_top = scope.owner is None and scope.node in scope.module.tree.body
            if is_top and not scope.node.name.startswith("_"):
                named = 2 if scope.node.name in _RUNS else -2
                yield _Candidate(self._outside_score(scope) + self._port_score(scope) + named, scope, None)
        derived = Counter(
            id(base.node) for class_ in self._sources.classes for base in self._sources.base_classes(class_)
        )
        for scope in self._sources.classes:
            bases = {base.rpartition(".")[2] for base in self._sources.bases(scope)}
            methods = methods_of(self._sources, scope)
            run = _run_method(methods)
            if bases & _NO_ROBOTS or (form_of(self._sources, scope) and not run):
                continue
            begin = methods.get("__init__")
            most = max((derived[id(base.node)] for base in self._sources.base_classes(scope)), default=0)
            is_kind = bool(derived[id(scope.node)]) or most > 1  # one of several, as of states or simulated devices
            score = self._outside_score(scope) + (1 if run else -1) - 3 * is_kind
            yield _Candidate(score + (self._port_score(begin) if begin else 0), scope, methods.get(run))

    def _port_score(self, scope: Scope) -> float:
        assert not isinstance(scope.node, ast.ClassDef)
        roles = {self._ports.port(scope, name).role for name in parameter_names(scope.node) if name != "self"}
        return 4.0 if roles & {"bus", "publish", "queue"} else 1.0 if "device" in roles else 0.0

    def _outside_score(self, scope: Scope) -> float:
        """More where nothing of the code calls it, most where its main program does."""
        calls = [call.scope for call in self._flow.calls.get(scope.node.name, ())
                 if call.scope is None or call.scope.node is not scope.node]  # fmt: skip
        if scope.node.name in self._used:
            return 2.5 if calls else 3.5
        return 2.5 if None in calls else -1.0 if calls else 1.5

    def _read(self, candidate: _Candidate) -> Entry:
        scope, method = candidate.scope, candidate.method
        module, name = scope.module.name, scope.node.name
        if not isinstance(scope.node, ast.ClassDef):
            ports = tuple(self._ports.ports(scope))
            return Entry(module, name, "", _is_async(scope), ports, (), scope.location)
        methods = methods_of(self._sources, scope)
        begin = methods.get("__init__")
        ports = tuple(self._ports.ports(begin, skip=1)) if begin is not None else tuple(self._ports.fields(scope))
        method_ports = tuple(self._ports.ports(method, skip=1)) if method is not None else ()
        # If no method runs it, its bus calls one back.
        is_async = any(_is_async(called) for called in ([method] if method is not None else methods.values()))
        run = method.node.name if method is not None else ""
        return Entry(module, name, run, is_async, ports, method_ports, scope.location)


def _run_method(methods: dict[str, Scope]) -> str:
    """The method that runs the robot: its name says so, or it is the only public one with a loop that waits."""
    named = next((name for name in _RUNS if name in methods), "")
    loops = [name for name, method in methods.items()
             if not name.startswith("_") and _is_loop(method)]  # fmt: skip
    return named or (loops[0] if len(loops) == 1 else "")


def _is_loop(method: Scope) -> bool:
    for node in ast.walk(method.node):
        if isinstance(node, ast.While):
            calls = {last_name(part.func) for part in ast.walk(node) if isinstance(part, ast.Call)}
            if calls & {"sleep", "wait", "get", "recv", "poll"}:
                return True
    return False


def _is_async(scope: Scope) -> bool:
    return isinstance(scope.node, ast.AsyncFunctionDef)


USERS = ("test*.py", "tests/**/*.py", "test/**/*.py", "demo*.py", "demos/**/*.py", "main*.py", "example*.py",
         "examples/**/*.py", "run*.py", "scripts/**/*.py", "__main__.py")  # fmt: skip
"""Patterns of programs that use the code."""

MAX_FILES, MAX_BYTES = 100, 200_000
"""More files, and longer ones, are not read."""


def read_calls(sources: Sources) -> Counter[str]:
    """Calls of programs, next to the code or in it -> how many of them are in loops, and pass no text."""
    calls: Counter[str] = Counter()
    read = {module.file for module in sources.modules}
    roots = [sources.root, *(sources.root / name for name in sources.top_level), sources.root.parent]
    files = dict.fromkeys(path for root in roots if root.is_dir() for path in _files(root, sources.root))
    for path in list(files)[:MAX_FILES]:
        if path.is_relative_to(sources.root) and path.relative_to(sources.root).as_posix() in read:
            continue
        try:
            tree = ast.parse(path.read_bytes())
        except (SyntaxError, ValueError, OSError, RecursionError):
            continue
        calls.update(_calls(tree))
    for module in sources.modules:  # `if __name__ == "__main__":`
        for statement in module.tree.body:
            if isinstance(statement, ast.If) and "__name__" in ast.unparse(statement.test):
                calls.update(_calls(statement))
    return calls


def _files(root: Path, code: Path) -> Iterator[Path]:
    patterns = USERS if root != code.parent else USERS[1:3]  # `tests/` beside `src/`
    for pattern in patterns:
        for path in sorted(root.glob(pattern)):
            if path.is_file() and path.stat().st_size <= MAX_BYTES:
                yield path


def _calls(node: ast.AST) -> Counter[str]:
    """The last part of what is called, but for functions of modules, such as `time.sleep`."""
    modules = {alias.asname or alias.name.partition(".")[0]
               for part in ast.walk(node) if isinstance(part, ast.Import) for alias in part.names}  # fmt: skip
    calls: Counter[str] = Counter()
    waiting: list[tuple[ast.AST, int]] = [(node, 0)]
    while waiting:
        each, depth = waiting.pop()
        inner = 0 if isinstance(each, ast.If) else depth + isinstance(each, ast.For | ast.While | ast.AsyncFor)
        waiting += [(child, inner) for child in ast.iter_child_nodes(each)]
        if isinstance(each, ast.Call):
            owner, _, name = name_with_dots(each.func).rpartition(".")
            passed = (*each.args, *(keyword.value for keyword in each.keywords))
            has_texts = any(isinstance(getattr(value, "value", None), str) for value in passed)
            if owner not in modules or name[:1].isupper():
                calls[name or getattr(each.func, "attr", "")] += depth > 0 and not has_texts
    return calls
