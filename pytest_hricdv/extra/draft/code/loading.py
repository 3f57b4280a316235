"""First step of an analysis: `find` parses the files of a package, and neighbouring modules that it imports."""

from __future__ import annotations

import ast
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from importlib.machinery import PathFinder
from pathlib import Path

from pytest_hricdv._base.message import nearest
from pytest_hricdv.extra.draft.code.sources import DraftError, Module, Sources
from pytest_hricdv.extra.draft.code_model import CodeLine, Problem

MAX_BYTES = 2_000_000
"""A longer file is not code that anybody wrote."""

MAX_NESTED = 2_000
"""Depth of a syntax tree: each level takes the analyses up to ten of the 30,000 nested calls that they have."""

NOT_CODE = ("test", "tests", "conftest", "setup", "docs", "demo", "demos", "example", "examples", "__main__")
"""Modules of these names, and those that begin with `test_`, use the code under test and are not part of it."""


def find(package: str, start: Path) -> Sources:
    """Find and parse the code of a package, a module, or a path of one.

    Args:
        package: dotted name that can be imported from `start`, from `start/src` or from Python's path; or a path.
        start: folder where the search begins.

    Raises:
        DraftError: there is no such package, or it has no Python source.
    """
    root, _, file = locate(package, start)
    paths = [file]
    if file.is_dir() or file.name == "__init__.py":
        folder = file if file.is_dir() else file.parent
        paths = sorted(path for path in folder.rglob("*.py") if not _is_skipped(path.relative_to(folder).parts))
        if not paths:
            raise DraftError(f"{folder}: expected a Python package with a file *.py that is not a test")
    sources = _read(package, root, paths)
    scripts = _script_folder(sources)
    if scripts is None:
        return sources
    return _read(package, scripts, [path for path in paths if path != scripts / "__init__.py"])


def _read(package: str, root: Path, paths: Sequence[Path]) -> Sources:
    """Parse files, and the neighbouring modules that they import from a folder on Python's path."""
    problems: list[Problem] = []
    files = [(_module_name(path, root), path) for path in paths]
    modules = {module.name: module for module in _parse(files, root, problems)}
    outside = _follow(modules, root, problems)
    if not modules:
        reasons = "; ".join(f"{problem.location}: {problem.text}" for problem in problems[:3])
        raise DraftError(f"{package}: no module could be read{f': {reasons}' if reasons else ''}")
    asked = files[0][0] if len(files) == 1 else ""
    return Sources(package, root, tuple(modules.values()), tuple(problems), outside, asked)


def _script_folder(sources: Sources) -> Path | None:
    """The folder whose modules import each other by their bare names, as the scripts of a folder do; None: no such one.

    Where they are run, Python has their own folder on its path, whether it has an `__init__.py` or not.
    """
    folders: Counter[Path] = Counter()
    for dotted, location in sources.outside:
        folder = (sources.root / location.file).parent
        top = dotted.partition(".")[0]
        is_elsewhere = top in sys.stdlib_module_names or PathFinder.find_spec(top) is not None
        if folder != sources.root and not is_elsewhere and _path_of(dotted, folder) is not None:
            folders[folder] += 1
    if not folders:
        return None
    found = folders.most_common(1)[0][0]
    inside = [module for module in sources.modules if (sources.root / module.file).is_relative_to(found)]
    is_package = any(
        isinstance(node, ast.ImportFrom) and node.level for module in inside for node in ast.walk(module.tree)
    )
    return None if is_package or len(inside) < len(sources.modules) else found


def locate(package: str, start: Path) -> tuple[Path, str, Path]:
    as_path = (start / package).expanduser()
    is_name = all(part.isidentifier() for part in package.split("."))
    if ("/" in package or package.endswith(".py") or not is_name) and as_path.exists():
        file = as_path.resolve()
        root = file.parent
        while (root / "__init__.py").is_file():
            root = root.parent
        return root, _module_name(file, root), file
    parts = package.split(".")
    if not is_name:
        raise DraftError(
            f"--from={package}: expected PACKAGE, PACKAGE:FUNCTION, or the path of a folder or file of Python"
        )
    search: list[str] | None = [str(start), str(start / "src"), *sys.path]
    found_at, spec = None, None
    for number in range(len(parts)):
        try:
            spec = PathFinder.find_spec(".".join(parts[: number + 1]), search)
        except (ImportError, KeyError, ValueError, AttributeError):  # of a package that is none
            spec = None
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
        raise DraftError(f"--from={package}: expected Python source, got {spec.origin}")
    return found_at.resolve(), package, Path(spec.origin).resolve()


def _module_name(path: Path, root: Path) -> str:
    parts = path.relative_to(root).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _is_skipped(parts: Sequence[str]) -> bool:
    names = [part.removesuffix(".py") for part in parts]
    return any(name in NOT_CODE or name.startswith(("test_", ".")) or name == "__pycache__" for name in names)


def _parse(files: Sequence[tuple[str, Path]], root: Path, problems: list[Problem]) -> Iterator[Module]:
    for name, path in files:
        relative = path.relative_to(root).as_posix()
        try:
            if path.stat().st_size > MAX_BYTES:
                raise OSError(f"longer than {MAX_BYTES:,} bytes")
            tree = ast.parse(path.read_bytes())
            if _is_deep(tree):
                raise RecursionError
        except RecursionError:
            problems.append(Problem("syntax", "nested too deeply: the file is left out", CodeLine(relative, 1)))
            continue
        except SyntaxError as error:
            location = CodeLine(relative, error.lineno or 1)
            problems.append(Problem("syntax", f"{error.msg}: the file is left out; fix it, and draft again", location))
            continue
        except (OSError, ValueError) as error:
            problems.append(Problem("syntax", f"cannot be read: {error}", CodeLine(relative, 1)))
            continue
        imports, stars = _imports(tree, name, path.name == "__init__.py")
        yield Module(name, relative, tree, imports, stars)


def _is_deep(tree: ast.AST) -> bool:
    """Whether expressions or blocks are within each other more often than the analyses can follow."""
    level: list[ast.AST] = [tree]
    for _ in range(MAX_NESTED):
        level = [child for node in level for child in ast.iter_child_nodes(node)]
        if not level:
            return False
    return True


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


def _follow(modules: dict[str, Module], root: Path, problems: list[Problem]) -> tuple[tuple[str, CodeLine], ...]:
    """Add the neighbouring modules that the code imports; returns what it imports from elsewhere."""
    outside: dict[str, CodeLine] = {}
    waiting = list(modules.values())
    while waiting:
        module = waiting.pop(0)
        for dotted, node in _import_names(module):
            path = _path_of(dotted, root)
            if path is None:
                own = {name.partition(".")[0] for name in modules}
                if dotted.partition(".")[0] not in own or _is_interface(dotted):
                    outside.setdefault(dotted, module.location(node))
                continue
            name = _module_name(path, root)
            if name in modules or _is_skipped(path.relative_to(root).parts):
                continue
            for new in _parse([(name, path)], root, problems):
                modules[new.name] = new
                waiting.append(new)
    return tuple(outside.items())


def _import_names(module: Module) -> Iterator[tuple[str, ast.stmt]]:
    for node in ast.walk(module.tree):
        if isinstance(node, ast.Import):
            yield from ((alias.name, node) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            is_package = module.file.endswith("__init__.py")
            names, stars = _imports(ast.Module([node], []), module.name, is_package)
            yield from ((dotted, node) for dotted in (*names.values(), *stars))


INTERFACES = ("msg", "srv", "action")
"""Modules of a package of ROS 2 in which classes are, made of its interface files: they are not code under test."""


def _is_interface(dotted: str) -> bool:
    return len(dotted.split(".")) > 1 and dotted.split(".")[1] in INTERFACES


def _path_of(dotted: str, root: Path) -> Path | None:
    parts = dotted.split(".")
    kind = parts[1] if _is_interface(dotted) else ""
    if kind and any((root / parts[0] / kind).glob(f"*.{kind}")):
        return None  # Python next to interface files is of a build
    for cut in range(len(parts), 1 if kind else 0, -1):
        base = root.joinpath(*parts[:cut])
        for path in (base.with_suffix(".py"), base / "__init__.py"):
            if path.is_file():
                return path
    return None


def top_level_without(sources: Sources, word: bytes) -> tuple[str, ...]:
    """The top-level names, without modules that were not read and have a word in them: other programs of a package."""
    return tuple(name for package in sources.top_level for name in _without(sources, package, word))


def _without(sources: Sources, package: str, word: bytes) -> tuple[str, ...]:
    root = sources.root
    read = {root / module.file for module in sources.modules}
    files = [path for path in sorted((root / package).rglob("*.py"))
             if path in read or not _is_skipped(path.relative_to(root).parts)]  # fmt: skip
    left_out = {path for path in files if path not in read and word in path.read_bytes()}
    packages = {path for path in files if path.name == "__init__.py"}
    if not left_out or any(path.read_bytes().strip() for path in packages):
        return (package,)  # what is in a package itself cannot be named without all that is below it
    return tuple(_module_name(path, root) for path in files if path not in packages | left_out)
