"""The parsed sources of a package: modules, scopes, and what the names in them refer to; `loading` reads them."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from pytest_hricdv._base.message import InputError
from pytest_hricdv.extra.draft.code_model import CodeLine, Problem

Function = ast.FunctionDef | ast.AsyncFunctionDef


class DraftError(InputError):
    """No draft can be made; the message says why, and what to do."""


@dataclass(frozen=True)
class Module:
    """A parsed module; `imports` maps each imported local name to the dotted name that it stands for."""

    name: str
    file: str
    tree: ast.Module = field(repr=False, hash=False, compare=False)
    imports: dict[str, str] = field(repr=False, hash=False, compare=False)
    star_imports: tuple[str, ...] = ()

    def location(self, node: ast.AST) -> CodeLine:
        """The location of a node of its tree."""
        return CodeLine(self.file, getattr(node, "lineno", 1))

    @cached_property
    def scope(self) -> dict[str, ast.stmt]:
        """The top-level definitions and assignments, by name; the last one wins."""
        names: dict[str, ast.stmt] = {}
        for statement in _top_level(self.tree.body):
            for name in _names_bound(statement):
                names[name] = statement
        return names


@dataclass(frozen=True)
class Scope:
    """A function or class, and where it is defined; `owner` is the class of a method."""

    module: Module
    node: Function | ast.ClassDef
    owner: ast.ClassDef | None = None

    @property
    def location(self) -> CodeLine:
        """The location of its definition."""
        return self.module.location(self.node)


@dataclass(frozen=True)
class Sources:
    """All modules of the code under test."""

    package: str
    root: Path
    modules: tuple[Module, ...]
    problems: tuple[Problem, ...] = ()
    outside: tuple[tuple[str, CodeLine], ...] = ()
    """Dotted names imported from outside the code, each with its first location."""
    asked: str = ""
    """The module that was asked for; empty for a package."""

    @cached_property
    def by_name(self) -> dict[str, Module]:
        """Modules by dotted name."""
        return {module.name: module for module in self.modules}

    @property
    def top_level(self) -> tuple[str, ...]:
        """Names of the top-level modules and packages."""
        return tuple(dict.fromkeys(module.name.partition(".")[0] for module in self.modules))

    def definition(self, module: Module, name: str, depth: int = 0) -> tuple[Module, ast.stmt] | None:
        """The statement that defines a name such as `a` or `a.b`, also if imported; None if it is not in the code."""
        if depth > 8:  # cyclic imports
            return None
        head, _, rest = name.partition(".")
        if head in module.imports:
            return self._definition_of_dotted(f"{module.imports[head]}.{rest}".rstrip("."), depth)
        if head in module.scope:
            statement = module.scope[head]
            if rest and isinstance(statement, ast.ClassDef):
                inner = next((s for s in statement.body if rest in _names_bound(s)), None)
                return (module, inner) if inner is not None else None
            return (module, statement) if not rest else None
        for origin in module.star_imports:
            if origin in self.by_name:
                defined = self.definition(self.by_name[origin], name, depth + 1)
                if defined is not None:
                    return defined
        return None

    def _definition_of_dotted(self, dotted: str, depth: int) -> tuple[Module, ast.stmt] | None:
        parts = dotted.split(".")
        for cut in range(len(parts) - 1, 0, -1):
            module = self.by_name.get(".".join(parts[:cut]))
            if module is not None:
                return self.definition(module, ".".join(parts[cut:]), depth + 1)
        return None

    def class_of(self, module: Module, expression: ast.expr | None) -> Scope | None:
        """The class that an expression names; None if it is not in the code."""
        name = name_with_dots(expression)
        defined = self.definition(module, name) if name else None
        if defined is not None and isinstance(defined[1], ast.ClassDef):
            return Scope(defined[0], defined[1])
        return None

    def class_named(self, module: str, name: str) -> Scope | None:
        """The class with this name in a module; None if there is none."""
        return next((own for own in self.classes if (own.module.name, own.node.name) == (module, name)), None)

    @cached_property
    def classes(self) -> tuple[Scope, ...]:
        """All classes, including nested ones."""
        return tuple(
            Scope(module, node)
            for module in self.modules
            for node in ast.walk(module.tree)
            if isinstance(node, ast.ClassDef)
        )

    @cached_property
    def functions(self) -> tuple[Scope, ...]:
        """All functions and methods, including nested ones."""
        return tuple(scope for module in self.modules for scope in _functions(module, module.tree, None))

    def bases(self, scope: Scope) -> tuple[str, ...]:
        """Dotted names of the bases of a class, and of the bases of its base classes, with imports resolved."""
        return tuple(
            resolve_import(class_.module, _without_arguments(base))
            for class_ in (scope, *self.base_classes(scope))
            for base in _class_of_scope(class_).bases
        )

    def base_classes(self, scope: Scope) -> tuple[Scope, ...]:
        """The base classes of a class that are in the code, direct and indirect, each once."""
        found: dict[int, Scope] = {id(scope.node): scope}
        waiting = [scope]
        while waiting:
            class_ = waiting.pop(0)
            for base in _class_of_scope(class_).bases:
                own = self.class_of(class_.module, _without_arguments(base))
                if own is not None and id(own.node) not in found:
                    found[id(own.node)] = own
                    waiting.append(own)
        return tuple(found.values())[1:]


def _class_of_scope(scope: Scope) -> ast.ClassDef:
    assert isinstance(scope.node, ast.ClassDef)
    return scope.node


def _without_arguments(base: ast.expr) -> ast.expr:
    """`Base` for `Base[int]`."""
    return base.value if isinstance(base, ast.Subscript) else base


def name_with_dots(expression: ast.AST | None) -> str:
    """`a.b.c` of a name, an attribute, or a string with one; empty for anything else."""
    if isinstance(expression, ast.Name):
        return expression.id
    if isinstance(expression, ast.Attribute):
        value = name_with_dots(expression.value)
        return f"{value}.{expression.attr}" if value else ""
    if isinstance(expression, ast.Constant) and isinstance(expression.value, str):
        return expression.value if all(part.isidentifier() for part in expression.value.split(".")) else ""
    return ""


def resolve_import(module: Module, expression: ast.AST | None) -> str:
    """The dotted name of an expression, with imports resolved: `sleep` -> `time.sleep`."""
    head, dot, rest = name_with_dots(expression).partition(".")
    return module.imports.get(head, head) + dot + rest


def _top_level(body: Sequence[ast.stmt]) -> Iterator[ast.stmt]:
    for statement in body:
        yield statement
        if isinstance(statement, ast.If | ast.Try | ast.With):
            yield from _top_level(statement.body)
            yield from _top_level(getattr(statement, "orelse", []))
            for handler in getattr(statement, "handlers", []):
                yield from _top_level(handler.body)


def _names_bound(statement: ast.stmt) -> tuple[str, ...]:
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


def find_around(file: Path, line: int) -> list[Function | ast.ClassDef]:
    """The functions and classes around a line, the innermost last; none if the file cannot be read."""
    try:
        tree = ast.parse(file.read_bytes())
    except (OSError, SyntaxError, ValueError, RecursionError):
        return []
    around = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef)
              and node.lineno <= line <= (node.end_lineno or node.lineno)]  # fmt: skip
    return sorted(around, key=lambda node: node.lineno)
