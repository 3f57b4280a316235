"""Code points: where nodes of the code under test can be held, and which data each statement reads and writes.

`points_of` returns the `CodePoints` of packages, and the changes that instrument their files, for
`scheduler.instrument_points`. A statement or lambda has a point before it, and at each element of its comprehensions. A
statement that reads and then writes the same data, as `self.count += 1` does, has a second point in between, where
another thread may run, too.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from copy import copy
from dataclasses import dataclass, field
from pathlib import Path

from pytest_hricdv.coverage.source_files import ModuleFile, module_files
from pytest_hricdv.execution.faulty_import import text_as_loaded
from pytest_hricdv.execution.instrumented_code import Change
from pytest_hricdv.generate.schedule import WRITES

HOOK, BETWEEN = "__hricdv_point__", "__hricdv_between__"
"""The functions that instrumented code calls: before a statement, and with the value that it is about to write."""

LOCAL_LOCK = "a lock"
"""The name, as data, of all locks in local variables: which lock it is, is only known in a run."""

_COMPOUND = (ast.If, ast.While, ast.For, ast.AsyncFor, ast.With, ast.AsyncWith, ast.Try, ast.Match)
_DEFINITIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
_LEFT_OUT = (*_DEFINITIONS, ast.Import, ast.ImportFrom, ast.Global, ast.Nonlocal, ast.Pass)


@dataclass(frozen=True)
class DataAccess:
    """The data that a statement reads and writes, by the names of attributes and of variables that functions share.

    What is called on an attribute may change it, so it counts as written.
    """

    reads: frozenset[str] = frozenset()
    writes: frozenset[str] = frozenset()


@dataclass
class CodePoints:
    """The points of files, by their numbers in the order in which they were instrumented.

    Args:
        written: data that some statement of the code writes; a statement that accesses none of it, calls no method and
            takes no lock has no point, unless a function or loop starts with it. None: all statements have one.
    """

    written: frozenset[str] | None = None
    accesses: dict[str, DataAccess] = field(default_factory=dict)
    """`file:line` of each -> what its statements read and write."""
    starts: dict[str, str] = field(default_factory=dict)
    """Place of the first statement of each function, and of the body of each loop -> what begins there."""
    _numbers: dict[str, int] = field(default_factory=dict)

    @property
    def places(self) -> list[str]:
        """By their numbers."""
        return [*self._numbers]

    def instrument(self, file: str) -> _PointInserter:
        """What changes the tree of a file with this name."""
        return _PointInserter(file, self)

    def add(self, place: str, access: DataAccess) -> int:
        """The number of a place where another statement accesses data."""
        before = self.accesses.get(place, DataAccess())
        self.accesses[place] = DataAccess(before.reads | access.reads, before.writes | access.writes)
        return self._numbers.setdefault(place, len(self._numbers))

    def matters(self, statement: ast.stmt, place: str, access: DataAccess) -> bool:
        """Whether another order can make a difference before a statement."""
        takes_lock = isinstance(statement, ast.With | ast.AsyncWith)
        if self.written is None or takes_lock or place in self.starts or access.writes or access.reads & self.written:
            return True
        parts = (part for node in _header(statement) for part in ast.walk(node))
        return any(isinstance(part, ast.Call) and isinstance(part.func, ast.Attribute) for part in parts)


def points_of(packages: Sequence[str]) -> tuple[CodePoints, list[tuple[Path, str, Change]]]:
    """The points of code, and of each file its path, its text, and what inserts them."""
    files = [
        (file.path, text_as_loaded(file.path), _name_of(file))
        for file in module_files(packages, Path())
        if not file.problem
    ]
    every = CodePoints()
    for _, text, name in files:
        every.instrument(name).visit(ast.parse(text))
    points = CodePoints(frozenset().union(*(access.writes for access in every.accesses.values())), starts=every.starts)
    return points, [(path, text, points.instrument(name).visit) for path, text, name in files]


def _name_of(file: ModuleFile) -> str:
    """`controller/robot.py` of the module `controller.robot`, wherever pytest was started."""
    folder = file.module.replace(".", "/")
    return f"{folder}/__init__.py" if file.path.name == "__init__.py" else f"{folder}.py"


class _PointInserter(ast.NodeTransformer):
    """Puts a call before each statement of a function."""

    def __init__(self, file: str, points: CodePoints) -> None:
        self._file = file
        self._points = points
        self._fixed: frozenset[str] = frozenset()
        self._shared: list[frozenset[str]] = []
        self._names: list[str] = []

    def visit_Module(self, node: ast.Module) -> ast.AST:
        """What its names stand for once and for all is not data."""
        self._fixed = _constant_names(node)
        return self.generic_visit(node)

    def _function(self, node: ast.FunctionDef | ast.AsyncFunctionDef) -> ast.AST:
        self._shared.append(_own_names(node) | self._fixed)
        self._names.append(node.name)
        self._begin(node.body, "")
        node.body = self._block(node.body)
        self._names.pop()
        self._shared.pop()
        return node

    def visit_Lambda(self, node: ast.Lambda) -> ast.AST:
        """Puts a call before its expression."""
        self.generic_visit(node)
        body = node.body
        statement, place = ast.copy_location(ast.Expr(body), body), f"{self._file}:{body.lineno}"
        access = access_of(statement, _own_names(node) | self._fixed)
        if self._points.matters(statement, place, access):
            number = ast.Constant(self._points.add(place, access))
            _ElementPoints(number).visit(body)
            call = ast.Call(ast.Name(HOOK, ast.Load()), [number], [])
            both = ast.copy_location(ast.Tuple([ast.copy_location(call, body), body], ast.Load()), body)
            node.body = ast.copy_location(ast.Subscript(both, ast.Constant(1), ast.Load()), body)
        return node

    def visit_ClassDef(self, node: ast.ClassDef) -> ast.AST:
        """Names its functions after it."""
        self._names.append(node.name)
        self.generic_visit(node)
        self._names.pop()
        return node

    def _begin(self, body: Sequence[ast.stmt], what: str, access: DataAccess | None = None) -> None:
        first = next(
            (statement for statement in body if not isinstance(statement, _LEFT_OUT) and not _is_text(statement)), None
        )
        if first is not None:
            place = f"{self._file}:{first.lineno}"
            self._points.starts.setdefault(place, f"{what}{'.'.join(self._names)}")
            if access is not None:
                self._points.add(place, access)

    visit_FunctionDef = visit_AsyncFunctionDef = _function  # noqa: N815 (names of `ast.NodeVisitor`)

    def _block(self, statements: Sequence[ast.stmt]) -> list[ast.stmt]:
        made: list[ast.stmt] = []
        for statement in statements:
            if _is_text(statement) or isinstance(statement, _LEFT_OUT):
                made.append(self._inside(statement))
                continue
            access, place = access_of(statement, self._shared[-1]), f"{self._file}:{statement.lineno}"
            if self._points.matters(statement, place, access):
                number = ast.Constant(self._points.add(place, access))
                call = ast.Call(ast.Name(HOOK, ast.Load()), [number], [])
                made.append(ast.copy_location(ast.Expr(ast.copy_location(call, statement)), statement))
                for part in _header(statement):
                    _ElementPoints(number).visit(part)
            made.append(self._split(self._inside(statement), f"{place}{WRITES}", access))
        return made

    def _inside(self, statement: ast.stmt) -> ast.stmt:
        if isinstance(statement, _COMPOUND):
            for part in _header(statement):
                self.visit(part)
            if isinstance(statement, ast.For | ast.AsyncFor | ast.While):
                # What its header reads, each iteration reads again.
                access = access_of(statement, self._shared[-1])
                self._begin(statement.body, f"the loop of line {statement.lineno} in ", access)
            for name in ("body", "orelse", "finalbody"):
                if getattr(statement, name, None):
                    setattr(statement, name, self._block(getattr(statement, name)))
            for block in (*getattr(statement, "handlers", ()), *getattr(statement, "cases", ())):
                block.body = self._block(block.body)
            return statement
        visited = self.visit(statement)
        assert isinstance(visited, ast.stmt)
        return visited

    def _split(self, statement: ast.stmt, place: str, access: DataAccess) -> ast.stmt:
        """A statement that reads what it writes, with its value passed through the hook once all is read."""
        if not access.reads & access.writes or not isinstance(statement, ast.Assign | ast.AugAssign):
            return statement
        if isinstance(statement, ast.Assign):
            targets, read = statement.targets, []
        elif any(isinstance(part, ast.Slice) for part in ast.walk(statement.target)):
            return statement
        else:
            # The hook does the operation: what is read is read before the value, as in the statement.
            loaded, stored = _read_first(statement.target)
            operation = ast.Constant(type(statement.op).__name__)
            targets, read = [stored], [ast.keyword("read", loaded), ast.keyword("operation", operation)]
        number = ast.Constant(self._points.add(place, DataAccess(writes=access.writes)))
        call = ast.Call(ast.Name(BETWEEN, ast.Load()), [number], [*read, ast.keyword("value", statement.value)])
        made = ast.copy_location(ast.Assign(targets, ast.copy_location(call, statement)), statement)
        return _keep_briefly(made) if read and not isinstance(targets[0], ast.Name) else made


def _keep_briefly(statement: ast.Assign) -> ast.stmt:
    """The statement, after which the variables of `_read_first` are gone, whether it raises an error or not."""
    names = ("__hricdv_value__", "__hricdv_slice__")
    begin = ast.Assign([ast.Name(name, ast.Store()) for name in names], ast.Constant(None))
    end = ast.copy_location(ast.Delete([ast.Name(name, ast.Del()) for name in names]), statement)
    return ast.copy_location(ast.Try([ast.copy_location(begin, statement), statement], [], [], [end]), statement)


def _read_first(target: ast.Name | ast.Attribute | ast.Subscript) -> tuple[ast.expr, ast.expr]:
    """What reads the target of `+=`, and what writes it then: its object and its key are evaluated once."""
    loaded, stored = copy(target), copy(target)
    loaded.ctx, stored.ctx = ast.Load(), ast.Store()
    for name in ("value", "slice"):
        if hasattr(target, name):
            kept = f"__hricdv_{name}__"
            setattr(loaded, name, ast.NamedExpr(ast.Name(kept, ast.Store()), getattr(target, name)))
            setattr(stored, name, ast.Name(kept, ast.Load()))
    return loaded, stored


@dataclass
class _ElementPoints(ast.NodeTransformer):
    """Passes each element of a comprehension, or its first condition, through the hook, as the statement's point."""

    number: ast.Constant

    def _comprehension(self, node: ast.ListComp | ast.SetComp | ast.GeneratorExp | ast.DictComp) -> ast.AST:
        self.generic_visit(node)
        if conditions := node.generators[-1].ifs:
            conditions[0] = self._call_hook(conditions[0])
        elif isinstance(node, ast.DictComp):
            node.value = self._call_hook(node.value)
        else:
            node.elt = self._call_hook(node.elt)
        return node

    visit_ListComp = visit_SetComp = visit_GeneratorExp = visit_DictComp = _comprehension  # noqa: N815

    def visit_Lambda(self, node: ast.Lambda) -> ast.AST:
        """Executed at another time, so it has a point of its own."""
        return node

    def _call_hook(self, value: ast.expr) -> ast.expr:
        return ast.copy_location(ast.Call(ast.Name(BETWEEN, ast.Load()), [self.number, value], []), value)


def _is_text(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)


def _constant_names(module: ast.Module) -> frozenset[str]:
    """Names of imports, functions and classes of a module that nothing assigns to."""
    imported = {
        (alias.asname or alias.name).partition(".")[0]
        for node in ast.walk(module)
        if isinstance(node, ast.Import | ast.ImportFrom)
        for alias in node.names
    }
    defined = {node.name for node in module.body if isinstance(node, _DEFINITIONS)}
    assigned = {
        node.id for node in ast.walk(module) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store | ast.Del)
    }
    return frozenset((imported | defined) - assigned)


def _own_names(function: ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda) -> frozenset[str]:
    """Names of local variables: what a function assigns, and does not declare global or nonlocal; its parameters."""
    names = {part.arg for part in ast.walk(function.args) if isinstance(part, ast.arg)}
    declared: set[str] = set()
    for node in _own_nodes(function):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store | ast.Del):
            names.add(node.id)
        elif isinstance(node, ast.Global | ast.Nonlocal):
            declared.update(node.names)
    return frozenset(names - declared)


def _own_nodes(function: ast.AST) -> Iterator[ast.AST]:
    for child in ast.iter_child_nodes(function):
        yield child
        if not isinstance(child, (*_DEFINITIONS, ast.Lambda)):
            yield from _own_nodes(child)


def access_of(statement: ast.stmt, own: frozenset[str]) -> DataAccess:
    """What a statement of a function with these own variables reads and writes; of a compound one, its first line."""
    reads: set[str] = set()
    writes: set[str] = set()
    for node in _header(statement):
        for part in ast.walk(node):
            match part:
                case ast.Attribute(attr=name, ctx=ast.Store() | ast.Del()):
                    writes.add(f".{name}")
                case ast.Attribute(attr=name):
                    reads.add(f".{name}")
                case ast.Name(id=name, ctx=ast.Store() | ast.Del()) if name not in own:
                    writes.add(name)
                case ast.Name(id=name) if name not in own:
                    reads.add(name)
                case ast.Call(func=ast.Attribute(value=ast.expr() as value)):
                    writes.update(_name(value, own))
                case ast.Subscript(value=value, ctx=ast.Store() | ast.Del()):
                    writes.update(_name(value, own))
    if isinstance(statement, ast.AugAssign):
        reads.update(_name(statement.target, own))
    if isinstance(statement, ast.With | ast.AsyncWith):
        for item in statement.items:
            names = {*_name(item.context_expr, own)}
            writes.update(names or ({LOCAL_LOCK} if isinstance(item.context_expr, ast.Name) else ()))
    return DataAccess(frozenset(reads), frozenset(writes))


def _name(node: ast.expr, own: frozenset[str]) -> Iterator[str]:
    if isinstance(node, ast.Attribute):
        yield f".{node.attr}"
    elif isinstance(node, ast.Name) and node.id not in own:
        yield node.id
    elif isinstance(node, ast.Subscript):
        yield from _name(node.value, own)


def _header(statement: ast.stmt) -> Iterator[ast.AST]:
    match statement:
        case ast.If(test=test) | ast.While(test=test):
            yield test
        case ast.For() | ast.AsyncFor():
            yield statement.target
            yield statement.iter
        case ast.With() | ast.AsyncWith():
            yield from (item.context_expr for item in statement.items)
            yield from (item.optional_vars for item in statement.items if item.optional_vars is not None)
        case ast.Match(subject=subject):
            yield subject
        case ast.Try():
            return
        case _:
            yield statement
