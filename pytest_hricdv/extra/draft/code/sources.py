"""The source of a package, found and parsed without importing any of it."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from importlib.machinery import PathFinder
from pathlib import Path

from pytest_hricdv._base.message import InputError
from pytest_hricdv._base.suggestion import nearest
from pytest_hricdv.extra.draft.code_model import Location, Problem

Function = ast.FunctionDef | ast.AsyncFunctionDef
NOT_CODE = ("test", "tests", "conftest", "setup", "docs")
"""Modules of these names, and those that begin with `test_`, are not the code under test."""


class DraftError(InputError):
    """No draft can be made; the text says why, and what to do."""


@dataclass(frozen=True)
class Module:
    """A parsed module; `imports` is the local name -> dotted name of what was imported under it."""

    name: str
    file: str
    tree: ast.Module = field(repr=False, hash=False, compare=False)
    imports: dict[str, str] = field(repr=False, hash=False, compare=False)
    star_imports: tuple[str, ...] = ()

    def location(self, node: ast.AST) -> Location:
        """Where a node of its tree is."""
        return Location(self.file, getattr(node, "lineno", 1))

    @cached_property
    def scope(self) -> dict[str, ast.stmt]:
        """The top-level definitions and assignments, by name; the last one counts."""
        names: dict[str, ast.stmt] = {}
        for statement in _top_level(self.tree.body):
            for name in _bound_names(statement):
                names[name] = statement
        return names


@dataclass(frozen=True)
class Scope:
    """A function or class with where it is defined: `owner` is the class around a method."""

    module: Module
    node: Function | ast.ClassDef
    owner: ast.ClassDef | None = None

    @property
    def location(self) -> Location:
        """Where it is defined."""
        return self.module.location(self.node)


@dataclass(frozen=True)
class Sources:
    """All modules of the code under test."""

    package: str
    root: Path
    modules: tuple[Module, ...]
    problems: tuple[Problem, ...] = ()
    outside: tuple[tuple[str, Location], ...] = ()
    """Dotted names that are imported and are not of the code, each with its first place."""

    @cached_property
    def by_name(self) -> dict[str, Module]:
        """Module by its dotted name."""
        return {module.name: module for module in self.modules}

    @property
    def top_level(self) -> tuple[str, ...]:
        """Names of the top-level modules and packages."""
        return tuple(dict.fromkeys(module.name.partition(".")[0] for module in self.modules))

    def top_level_without(self, word: bytes) -> tuple[str, ...]:
        """The same, without modules that were not read and have a word in them, such as other programs of a package."""
        return tuple(name for package in self.top_level for name in self._without(package, word))

    def _without(self, package: str, word: bytes) -> tuple[str, ...]:
        read = {self.root / module.file for module in self.modules}
        files = [path for path in sorted((self.root / package).rglob("*.py"))
                 if path in read or not _is_skipped(path.relative_to(self.root).parts)]  # fmt: skip
        left_out = {path for path in files if path not in read and word in path.read_bytes()}
        packages = {path for path in files if path.name == "__init__.py"}
        if not left_out or any(path.read_bytes().strip() for path in packages):
            return (package,)  # what is in a package itself cannot be named without all that is below it
        return tuple(_module_name(path, self.root) for path in files if path not in packages | left_out)

    def definition(self, module: Module, name: str, depth: int = 0) -> tuple[Module, ast.stmt] | None:
        """The statement that defines a name in a module, through imports and `a.b`; None: not of the code."""
        if depth > 8:  # imports that go round
            return None
        head, _, rest = name.partition(".")
        if head in module.imports:
            return self._dotted(f"{module.imports[head]}.{rest}".rstrip("."), depth)
        if head in module.scope:
            statement = module.scope[head]
            if rest and isinstance(statement, ast.ClassDef):
                inner = next((s for s in statement.body if rest in _bound_names(s)), None)
                return (module, inner) if inner is not None else None
            return (module, statement) if not rest else None
        for origin in module.star_imports:
            if origin in self.by_name:
                defined = self.definition(self.by_name[origin], name, depth + 1)
                if defined is not None:
                    return defined
        return None

    def _dotted(self, dotted: str, depth: int) -> tuple[Module, ast.stmt] | None:
        parts = dotted.split(".")
        for cut in range(len(parts) - 1, 0, -1):
            module = self.by_name.get(".".join(parts[:cut]))
            if module is not None:
                return self.definition(module, ".".join(parts[cut:]), depth + 1)
        return None

    def class_of(self, module: Module, expression: ast.expr | None) -> Scope | None:
        """The class of the code that an expression names."""
        name = dotted_name(expression)
        defined = self.definition(module, name) if name else None
        if defined is not None and isinstance(defined[1], ast.ClassDef):
            return Scope(defined[0], defined[1])
        return None

    @cached_property
    def classes(self) -> tuple[Scope, ...]:
        """All classes, also nested ones."""
        return tuple(
            Scope(module, node)
            for module in self.modules
            for node in ast.walk(module.tree)
            if isinstance(node, ast.ClassDef)
        )

    @cached_property
    def functions(self) -> tuple[Scope, ...]:
        """All functions and methods, also nested ones."""
        return tuple(scope for module in self.modules for scope in _functions(module, module.tree, None))

    def bases(self, scope: Scope) -> tuple[str, ...]:
        """Dotted names of the bases of a class, as imported, those of its bases in the code as well."""
        assert isinstance(scope.node, ast.ClassDef)
        names: list[str] = []
        for base in scope.node.bases:
            own = self.class_of(scope.module, _generic(base))
            names.append(imported_name(scope.module, _generic(base)))
            if own is not None and own.node is not scope.node:
                names += self.bases(own)
        return tuple(names)

    def base_classes(self, scope: Scope) -> tuple[Scope, ...]:
        """Those of the bases of a class that are classes of the code, and theirs."""
        assert isinstance(scope.node, ast.ClassDef)
        own = (self.class_of(scope.module, _generic(base)) for base in scope.node.bases)
        direct = [base for base in own if base is not None and base.node is not scope.node]
        return (*direct, *(further for base in direct for further in self.base_classes(base)))


def _generic(base: ast.expr) -> ast.expr:
    """`Base` of `Base[int]`."""
    return base.value if isinstance(base, ast.Subscript) else base


def dotted_name(expression: ast.AST | None) -> str:
    """`a.b.c` of a name or attribute; empty for anything else."""
    if isinstance(expression, ast.Name):
        return expression.id
    if isinstance(expression, ast.Attribute):
        value = dotted_name(expression.value)
        return f"{value}.{expression.attr}" if value else ""
    if isinstance(expression, ast.Constant) and isinstance(expression.value, str):
        return expression.value if all(part.isidentifier() for part in expression.value.split(".")) else ""
    return ""


def imported_name(module: Module, expression: ast.AST | None) -> str:
    """The same with the name under which something was imported replaced: `sleep` -> `time.sleep`."""
    head, dot, rest = dotted_name(expression).partition(".")
    return module.imports.get(head, head) + dot + rest


def find(package: str, start: Path) -> Sources:
    """Find and parse the code of a package, a module, or a path of one.

    Args:
        package: dotted name that can be imported from `start`, from `start/src` or from Python's path; or a path.
        start: folder where the search begins.

    Raises:
        DraftError: there is no such package, or it has no Python source.
    """
    root, name, file = _located(package, start)
    files = [(name, file)]
    if file.is_dir() or file.name == "__init__.py":
        folder = file if file.is_dir() else file.parent
        paths = sorted(path for path in folder.rglob("*.py") if not _is_skipped(path.relative_to(folder).parts))
        if not paths:
            raise DraftError(f"{folder}: expected a package of Python; it has no file *.py that is not a test")
        files = [(_module_name(path, root), path) for path in paths]
    problems: list[Problem] = []
    modules = {module.name: module for module in _parsed(files, root, problems)}
    outside = _follow(modules, root, problems)
    if not modules and not problems:
        raise DraftError(f"{package}: no module could be read")
    return Sources(package, root, tuple(modules.values()), tuple(problems), outside)


def _located(package: str, start: Path) -> tuple[Path, str, Path]:
    as_path = (start / package).expanduser()
    if ("/" in package or package.endswith(".py")) and as_path.exists():
        file = as_path.resolve()
        root = file.parent
        while (root / "__init__.py").is_file():
            root = root.parent
        return root, _module_name(file, root), file
    parts = package.split(".")
    if not all(part.isidentifier() for part in parts):
        raise DraftError(
            f"--from={package}: expected PACKAGE, PACKAGE:FUNCTION, or the path of a folder or file of Python"
        )
    search: list[str] | None = [str(start), str(start / "src"), *sys.path]
    found_at, spec = None, None
    for number in range(len(parts)):
        spec = PathFinder.find_spec(".".join(parts[: number + 1]), search)
        if spec is None:
            there = sorted(
                path.stem for path in start.iterdir() if path.suffix == ".py" or (path / "__init__.py").exists()
            )
            raise DraftError(
                f"--from={package}: no module {'.'.join(parts[: number + 1])!r} in {start} or on Python's path"
                f"{nearest(parts[number], there)}; run it in the folder that has the package, or give a path"
            )
        search = list(spec.submodule_search_locations or [])
        if number == 0:
            origin = Path(spec.origin) if spec.origin else Path(search[0]) / "__init__.py"
            found_at = origin.parent.parent if spec.submodule_search_locations is not None else origin.parent
    assert spec is not None
    assert found_at is not None
    if spec.origin is None:
        return found_at.resolve(), package, Path(search[0] if search else "").resolve()
    if not spec.origin.endswith(".py"):
        raise DraftError(f"--from={package}: expected source of Python; it is {spec.origin}")
    return found_at.resolve(), package, Path(spec.origin).resolve()


def _module_name(path: Path, root: Path) -> str:
    parts = path.relative_to(root).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _is_skipped(parts: Sequence[str]) -> bool:
    names = [part.removesuffix(".py") for part in parts]
    return any(name in NOT_CODE or name.startswith(("test_", ".")) or name == "__pycache__" for name in names)


def _parsed(files: Sequence[tuple[str, Path]], root: Path, problems: list[Problem]) -> Iterator[Module]:
    for name, path in files:
        relative = path.relative_to(root).as_posix()
        try:
            text = path.read_bytes()
            tree = ast.parse(text)
        except SyntaxError as error:
            location = Location(relative, error.lineno or 1)
            problems.append(Problem("syntax", f"{error.msg}: the file is left out; fix it, and draft again", location))
            continue
        except (OSError, ValueError) as error:
            problems.append(Problem("syntax", f"cannot be read: {error}", Location(relative, 1)))
            continue
        imports, stars = _imports(tree, name, path.name == "__init__.py")
        yield Module(name, relative, tree, imports, stars)


def _imports(tree: ast.Module, name: str, is_package: bool) -> tuple[dict[str, str], tuple[str, ...]]:
    imports: dict[str, str] = {}
    stars: list[str] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                local = alias.asname or alias.name.partition(".")[0]
                imports[local] = alias.name if alias.asname else local
        elif isinstance(node, ast.ImportFrom):
            origin = node.module or ""
            if node.level:
                parts = name.split(".")
                base = parts[: len(parts) - node.level + is_package]
                origin = ".".join([*base, *([node.module] if node.module else [])])
            for alias in node.names:
                if alias.name == "*":
                    stars.append(origin)
                else:
                    imports[alias.asname or alias.name] = f"{origin}.{alias.name}"
    return imports, tuple(stars)


def _follow(modules: dict[str, Module], root: Path, problems: list[Problem]) -> tuple[tuple[str, Location], ...]:
    """Add the modules beside the code that it imports; returns what it imports from elsewhere."""
    outside: dict[str, Location] = {}
    waiting = list(modules.values())
    while waiting:
        module = waiting.pop(0)
        for dotted, node in _imported(module):
            path = _path_of(dotted, root)
            if path is None:
                own = {name.partition(".")[0] for name in modules}
                if dotted.partition(".")[0] not in own or _is_interface(dotted):
                    outside.setdefault(dotted, module.location(node))
                continue
            name = _module_name(path, root)
            if name in modules or _is_skipped(path.relative_to(root).parts):
                continue
            for new in _parsed([(name, path)], root, problems):
                modules[new.name] = new
                waiting.append(new)
    return tuple(outside.items())


def _imported(module: Module) -> Iterator[tuple[str, ast.stmt]]:
    for node in ast.walk(module.tree):
        if isinstance(node, ast.Import):
            yield from ((alias.name, node) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            _, stars = _imports(ast.Module([node], []), module.name, module.file.endswith("__init__.py"))
            names = _imports(ast.Module([node], []), module.name, module.file.endswith("__init__.py"))[0]
            yield from ((dotted, node) for dotted in (*names.values(), *stars))


INTERFACES = ("msg", "srv", "action")
"""Modules of a package of ROS 2 in which classes are, made of its interface files: these are no code under test."""


def _is_interface(dotted: str) -> bool:
    return len(dotted.split(".")) > 1 and dotted.split(".")[1] in INTERFACES


def _path_of(dotted: str, root: Path) -> Path | None:
    parts = dotted.split(".")
    kind = parts[1] if _is_interface(dotted) else ""
    if kind and any((root / parts[0] / kind).glob(f"*.{kind}")):
        return None  # what Python there is beside interface files is of a build
    for cut in range(len(parts), 1 if kind else 0, -1):
        base = root.joinpath(*parts[:cut])
        for path in (base.with_suffix(".py"), base / "__init__.py"):
            if path.is_file():
                return path
    return None


def _top_level(body: Sequence[ast.stmt]) -> Iterator[ast.stmt]:
    for statement in body:
        yield statement
        if isinstance(statement, ast.If | ast.Try | ast.With):
            yield from _top_level(statement.body)
            yield from _top_level(getattr(statement, "orelse", []))
            for handler in getattr(statement, "handlers", []):
                yield from _top_level(handler.body)


def _bound_names(statement: ast.stmt) -> tuple[str, ...]:
    if isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
        return (statement.name,)
    if isinstance(statement, ast.Assign):
        return tuple(node.id for target in statement.targets for node in ast.walk(target) if isinstance(node, ast.Name))
    if isinstance(statement, ast.AnnAssign) and isinstance(statement.target, ast.Name):
        return (statement.target.id,)
    return ()


def _functions(module: Module, node: ast.AST, owner: ast.ClassDef | None) -> Iterator[Scope]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef):
            yield Scope(module, child, owner)
            yield from _functions(module, child, owner)
        else:
            yield from _functions(module, child, child if isinstance(child, ast.ClassDef) else owner)
