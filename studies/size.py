"""How large the package is, and how well it keeps the rules of its modules.

    python -m studies.size            the figures of this checkout
    python -m studies.size --at REV   those of another revision, from git
    python -m studies.size --broken   each place that breaks a rule, a line each
    python -m studies.size --check    fail where a figure is over its limit in [tool.hricdv-size] of pyproject.toml

The rules, also on limits, are in CONTRIBUTING.md.

The figures count lines of Python files as they are, with blank lines and comments.
"""

from __future__ import annotations

import argparse
import ast
import io
import re
import subprocess
import tarfile
import tempfile
import tomllib
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGE = "pytest_hricdv"
SHORT = 60
"""A module with fewer lines needs two users."""
LONG = 350
"""A module with more lines is two things."""
_IRREGULAR_WORDS = """
    been begun broken bound brought built chosen done drawn driven fallen felt found given gone heard held hidden kept
    known lost made meant met paid said seen sent shown spoken spent stood taken taught thought told understood woken
    worn written
"""
IRREGULAR = frozenset(_IRREGULAR_WORDS.split())
"""Participles that end in neither -ed nor -ing; without those that are verbs or nouns in this field, too."""
_NOUN_WORDS = """
    binding building ceiling embed encoding ending exceed heading learning listing logging mapping meaning naming
    need padding parsing rating reading recording ring sampling seed setting sibling speed spelling spring string
    succeed thing timing turing warning wording
"""
NOUNS = frozenset(_NOUN_WORDS.split())
"""Nouns and verbs that only look like participles."""
FIXED = frozenset({"Done", "enacted", "failed", "held_for", "locked", "tolerated"})
"""Participles that are fixed: by tests and requirements of users, by Python's locks, and by `report.json`."""
UNFOUNDED = re.compile(r"\b(chosen|heuristic|not measured|not tuned)\b", re.IGNORECASE)
"""What the comment of a constant without evidence says."""
RECIPES = ("an option", "an operator of requirements", "a column of a table on the page", "a lint rule for models")
"""The sections of CONTRIBUTING.md whose files are counted."""


@dataclass(frozen=True)
class Module:
    """A Python file of the package.

    Attributes:
        path: relative to the checkout.
        lines: how many it has.
        tree: its syntax tree.
        source: its lines.
    """

    path: str
    lines: int
    tree: ast.Module
    source: tuple[str, ...]

    @property
    def name(self) -> str:
        """What it is imported as."""
        return self.path.removesuffix(".py").removesuffix("/__init__").replace("/", ".")


def modules_of(root: Path) -> tuple[Module, ...]:
    """The package's modules, without the templates that `init` copies."""
    found = []
    for path in sorted((root / PACKAGE).rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        lines = tuple(text.splitlines())
        found.append(Module(path.relative_to(root).as_posix(), len(lines), ast.parse(text), lines))
    return tuple(found)


def definitions(modules: tuple[Module, ...]) -> Iterator[tuple[Module, ast.AST, str]]:
    """All classes and functions, with their names."""
    for module in modules:
        for node in ast.walk(module.tree):
            if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
                yield module, node, node.name


def is_participle(name: str) -> bool:
    """Whether a name is one: `mended`, `_running`, `Drifting`, or begins with one, as `known_causes`.

    >>> [is_participle(name) for name in ("mended", "is_kept", "read_seed", "naming")]
    [True, False, False, False]
    """
    words = re.findall(r"[A-Z]?[a-z]+", name)
    if name.startswith("__") or name in FIXED or not words:
        return False
    word = (words[-1] if name[:1].isupper() else words[0]).lower()
    looks = len(word) > 4 and word.endswith(("ed", "ing"))
    return word not in NOUNS and (looks or word in IRREGULAR)


def users(modules: tuple[Module, ...]) -> Mapping[str, set[str]]:
    """Module -> the modules that import it or something of it."""
    names = {module.name for module in modules}
    found: dict[str, set[str]] = defaultdict(set)
    for module in modules:
        for node in ast.walk(module.tree):
            if isinstance(node, ast.Import):
                imported = {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module:
                imported = {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
            else:
                continue
            for name in imported & names - {module.name}:
                found[name].add(module.name)
    return found


def _is_entry(module: Module) -> bool:
    """Whether it is loaded by name instead of being imported: a package, a command, a face of a feature."""
    path = Path(module.path)
    faces = {"part", "feature", "execution", "records", "merging", "view", "commands", "plugin", "__main__", "__init__"}
    return path.stem in faces or "/template" in module.path or "/people/" in module.path


def single_users(modules: tuple[Module, ...]) -> tuple[Module, ...]:
    """Modules that only one other imports, entries left out."""
    known = users(modules)
    return tuple(module for module in modules if not _is_entry(module) and len(known[module.name]) == 1)


def constants(modules: tuple[Module, ...]) -> Iterator[tuple[Module, ast.stmt, str, str]]:
    """Constants of modules whose value is a number, or several: with their comment, and the text around them."""
    for module in modules:
        body = module.tree.body
        for place, node in enumerate(body):
            target = node.targets[0] if isinstance(node, ast.Assign) else getattr(node, "target", None)
            value = getattr(node, "value", None)
            if not isinstance(node, ast.Assign | ast.AnnAssign) or not isinstance(target, ast.Name) or value is None:
                continue
            if not target.id.isupper() or not _is_numeric(value):
                continue
            after = body[place + 1] if place + 1 < len(body) else None
            comment = module.source[node.lineno - 2] if node.lineno > 1 else ""
            comment = comment if comment.lstrip().startswith("#") else ""
            comment += module.source[node.lineno - 1].partition("#")[2]
            if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant):
                comment += str(after.value.value)
            yield module, node, target.id, " ".join(comment.split())


def _is_numeric(value: ast.expr) -> bool:
    leaves = [node for node in ast.walk(value) if isinstance(node, ast.Constant)]
    plain = all(
        isinstance(node, ast.Constant | ast.BinOp | ast.UnaryOp | ast.Tuple | ast.operator | ast.unaryop | ast.Load)
        for node in ast.walk(value)
    )
    numbers = all(isinstance(leaf.value, int | float) and not isinstance(leaf.value, bool) for leaf in leaves)
    return plain and bool(leaves) and numbers


def duplicate_classes(modules: tuple[Module, ...]) -> Mapping[str, list[str]]:
    """Names of classes that several modules define, templates of projects left out -> where."""
    places: dict[str, list[str]] = defaultdict(list)
    for module in modules:
        if "/skeleton/" in module.path:
            continue
        for node in ast.walk(module.tree):
            if isinstance(node, ast.ClassDef):
                places[node.name].append(f"{module.path}:{node.lineno}")
    return {name: where for name, where in sorted(places.items()) if len(where) > 1}


def recipe_files(root: Path) -> Mapping[str, int]:
    """How many files the recipes of CONTRIBUTING.md name, one row a recipe."""
    text = (root / "CONTRIBUTING.md").read_text(encoding="utf-8")
    sections = dict(re.findall(r"^### \.\.\. (.+?)\n(.*?)(?=^##|\Z)", text, re.MULTILINE | re.DOTALL))
    suffixes = r"py|lark|json|md|toml|jinja|css|js"
    counted = {}
    for title in RECIPES:
        files = set(re.findall(rf"[\w./*]*\w\.(?:{suffixes})\b", sections.get(title, "")))
        counted[title] = len({Path(file).name for file in files})
    return counted


def _lines(root: Path, pattern: str) -> int:
    return sum(len(path.read_text(encoding="utf-8").splitlines()) for path in root.glob(pattern))


def figures(root: Path) -> dict[str, int]:
    """All figures, in the order in which they are printed."""
    modules = modules_of(root)
    extra = sum(module.lines for module in modules if "/extra/" in module.path)
    pages = [path for path in (root / "docs").rglob("*.md") if "_build" not in path.parts]
    studies = [path for path in pages if "studies" in path.relative_to(root / "docs").parts]
    words = {path: len(path.read_text(encoding="utf-8").split()) for path in [*pages, root / "README.md"]}
    names = list(definitions(modules))
    known = list(constants(modules))
    options = (root / PACKAGE / "session/option_table.py").read_text(encoding="utf-8")
    options += "".join(module for module in _option_modules(modules))
    return {
        "modules": len(modules),
        "lines": sum(module.lines for module in modules),
        "lines outside extra/": sum(module.lines for module in modules) - extra,
        "lines in extra/": extra,
        "lines of tests": _lines(root, "tests/**/*.py"),
        "tests (functions)": sum(
            len(re.findall(r"^\s*(?:async )?def test_", path.read_text(encoding="utf-8"), re.MULTILINE))
            for path in root.glob("tests/**/*.py")
        ),
        "words of documentation": sum(words.values()) - sum(words[path] for path in studies),
        "words of studies": sum(words[path] for path in studies),
        "words of the changelog": len((root / "CHANGELOG.md").read_text(encoding="utf-8").split()),
        "options": len(set(re.findall(r"\b(?:Value|Flag|Repeatable|Choice)\(\s*\"([\w-]+)\"", options))),
        "functions and classes": len(names),
        "named with a participle": sum(is_participle(name) for _, _, name in names),
        "class names defined twice": len(duplicate_classes(modules)),
        "modules with one user": len(single_users(modules)),
        f"modules over {LONG} lines": sum(module.lines > LONG for module in modules),
        "numeric constants": len(known),
        "of them without evidence": sum(bool(UNFOUNDED.search(comment)) for *_, comment in known),
        **{f"files for {title}": count for title, count in recipe_files(root).items()},
    }


def _option_modules(modules: tuple[Module, ...]) -> Iterator[str]:
    for module in modules:
        if Path(module.path).stem in ("options", "part", "feature"):
            yield "\n".join(module.source)


def broken(root: Path) -> Iterator[str]:
    """Each place that breaks a rule."""
    modules = modules_of(root)
    lone = {module.path for module in single_users(modules)}
    for module in modules:
        if module.lines > LONG:
            yield f"{module.path}: {module.lines} lines; at most {LONG}"
        if module.lines < SHORT and module.path in lone:
            yield f"{module.path}: {module.lines} lines and one user, {min(users(modules)[module.name])}"
    for name, where in duplicate_classes(modules).items():
        yield f"class {name}: {', '.join(where)}"
    for module, node, name in definitions(modules):
        if is_participle(name):
            yield f"{module.path}:{getattr(node, 'lineno', 0)}: {name} is a participle"
    for module, node, name, comment in constants(modules):
        if UNFOUNDED.search(comment):
            yield f"{module.path}:{node.lineno}: {name} without evidence"


def limits(root: Path) -> dict[str, int]:
    """Figure -> the highest value it may have."""
    configuration = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))
    return dict(configuration["tool"]["hricdv-size"])


def excesses(figures: Mapping[str, int], limits: Mapping[str, int]) -> Iterator[str]:
    """A line for each figure over its limit, and for each limit of no figure."""
    for name, limit in limits.items():
        if name not in figures:
            yield f"[tool.hricdv-size]: there is no figure {name!r}"
        elif figures[name] > limit:
            yield f"{name}: {figures[name]:,}; at most {limit:,}"


def _at(revision: str, folder: Path) -> Path:
    packed = subprocess.run(["git", "archive", revision], cwd=ROOT, check=True, capture_output=True).stdout
    with tarfile.open(fileobj=io.BytesIO(packed)) as archive:
        archive.extractall(folder, filter="data")
    return folder


def main() -> int:
    """Prints the figures, or the places."""
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(prog="python -m studies.size", description=__doc__, formatter_class=raw)
    parser.add_argument("--at", metavar="REV", help="another revision")
    parser.add_argument("--broken", action="store_true", help="list the places that break a rule")
    parser.add_argument("--check", action="store_true", help="fail where a figure is over its limit")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        root = _at(options.at, Path(folder)) if options.at else ROOT
        if options.check:
            lines = list(excesses(figures(root), limits(root)))
            print(*lines, sep="\n", end="\n" if lines else "")
            return int(bool(lines))
        if options.broken:
            lines = list(broken(root))
            print(*lines, sep="\n")
            print(*(f"{count} {kind}" for kind, count in Counter(_kind(line) for line in lines).items()), sep=", ")
        else:
            for name, value in figures(root).items():
                print(f"{value:>8,}  {name}")
    return 0


def _kind(line: str) -> str:
    for mark, kind in (("participle", "participles"), ("without evidence", "constants"), ("one user", "short modules")):
        if mark in line:
            return kind
    return "classes" if line.startswith("class ") else "long modules"


if __name__ == "__main__":
    raise SystemExit(main())
