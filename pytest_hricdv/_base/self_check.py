"""Detects code under test that has replaced functions of Python's library for the whole process.

The plugin itself uses functions that it bound when it was loaded. pytest, other plugins and other tests do not, so
`SessionReporter` reports functions that give wrong answers (`wrong_answers`), with the lines that replaced them, as
`json.dumps = None`. `library_conflict`, called when the plugin is loaded, finds files that hide a library's module.
"""

from __future__ import annotations

import ast
import builtins
import hashlib
import json
import math
import os
import re
import struct
import sys
import time
import zlib
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from itertools import takewhile
from pathlib import Path


def library_conflict() -> str:
    """A sentence on a file that Python takes for a module of its own library which the plugin imports; empty if none.

    Such a file lies in a folder of `sys.path` in front of the library, as those of `pythonpath` do.
    """
    library = os.path.dirname(os.__file__)
    for folder in takewhile(lambda folder: os.path.realpath(folder) != os.path.realpath(library), sys.path):
        with suppress(OSError):
            for entry in sorted(os.listdir(folder or os.curdir)):
                name, file = entry.removesuffix(".py"), os.path.join(folder or os.curdir, entry)
                loaded = str(getattr(sys.modules.get(name), "__file__", None) or file)
                is_hiding = entry.endswith(".py") and name in sys.stdlib_module_names and loaded == file
                if is_hiding and _is_imported_by_plugin(name):
                    return f"{file}: hides Python's own module {name}, which this plugin imports: rename it"
    return ""


def _is_imported_by_plugin(name: str) -> bool:
    imports = re.compile(rf"^\s*(import|from) {name}\b", re.MULTILINE)
    files = Path(__file__).parents[1].rglob("*.py")
    return any(imports.search(file.read_text(encoding="utf-8")) is not None for file in files)


def places_of_change(names: Iterable[str], packages: Iterable[str]) -> tuple[str, ...]:
    """The lines, `file:line`, where packages set or delete an attribute or item of such a name, or pass its text.

    If there are none, those where they do so with computed names, as in `sys.modules[name] = None`.

    Args:
        names: the changed names, with their modules.
        packages: names of modules, and of packages with all of their loaded modules.
    """
    # Of sys.modules['json.decoder'] the item is json.decoder, its owner modules.
    parts = [name[:-2].rpartition("['") if name.endswith("']") else name.rpartition(".") for name in names]
    lasts, owners = {last for _, _, last in parts}, {owner.rpartition(".")[2] for owner, _, _ in parts}
    roots = tuple(packages)
    exact: list[str] = []
    computed: list[str] = []
    for name, module in [*sys.modules.items()]:
        file = getattr(module, "__file__", None)
        if not isinstance(file, str) or not any(name == root or name.startswith(f"{root}.") for root in roots):
            continue
        with suppress(OSError, SyntaxError, ValueError, RecursionError):
            tree = ast.parse(Path(file).read_bytes())
            exact += [f"{file}:{line}" for line in _lines(tree, lasts)]
            computed += [f"{file}:{line}" for line in _lines_with_computed_names(tree, owners)]
    return tuple(exact or computed)


def _lines(tree: ast.AST, names: set[str]) -> Iterator[int]:
    for node in ast.walk(tree):
        match node:
            case ast.Attribute(attr=name, ctx=ast.Store() | ast.Del(), lineno=line) if name in names:
                yield line
            case ast.Subscript(slice=ast.Constant(value=str(name)), ctx=ast.Store() | ast.Del()) if name in names:
                yield node.lineno  # vars(json)["dumps"] = None
            case ast.Call(func=ast.Name(id="setattr" | "delattr"), args=[_, ast.Constant(value=str(name)), *_]) if (
                name in names
            ):
                yield node.lineno
            case ast.Call(func=ast.Attribute(value=ast.Attribute(attr=name))) if name in names:
                yield node.lineno  # a list or dict that is changed in place: sys.meta_path.insert(...)


def _lines_with_computed_names(tree: ast.AST, owners: set[str]) -> Iterator[int]:
    for node in ast.walk(tree):
        match node:
            case ast.Subscript(value=owner, slice=key, ctx=ast.Store() | ast.Del()) if not isinstance(
                key, ast.Constant
            ):
                changed: ast.expr = owner
            case ast.Call(func=ast.Name(id="setattr" | "delattr"), args=[owner, name, *_]) if not isinstance(
                name, ast.Constant
            ):
                changed = owner
            case ast.Call(func=ast.Attribute(value=owner, attr="update" | "pop" | "clear" | "setdefault")):
                changed = owner
            case _:
                continue
        if not owners.isdisjoint(_words(changed)):
            yield node.lineno


def _words(expression: ast.expr) -> Iterator[str]:
    """The names in an expression, as of `vars(json)` and of `sys.modules`."""
    for node in ast.walk(expression):
        if isinstance(node, ast.Name | ast.Attribute):
            yield node.id if isinstance(node, ast.Name) else node.attr


_ABC_SHA256 = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"  # FIPS 180-4, its first example
_ABC_MD5 = "900150983cd24fb0d6963f7d28e17f72"  # RFC 1321, A.5
_ABC_CRC32 = 0x352441C2  # of the polynomial of ISO 3309, as in zlib
_PLAIN = {"b": [1, 2.5, None, True], "a": "\u00e9"}
_WRITTEN = '{"a": "\\u00e9", "b": [1, 2.5, null, true]}'

# Each is looked up when it is called, as it may have been replaced.
_ANSWERS: dict[str, Callable[[], object]] = {
    "hashlib.sha256": lambda: hashlib.sha256(b"abc").hexdigest() == _ABC_SHA256,
    "hashlib.new": lambda: hashlib.new("sha256", b"abc").hexdigest() == _ABC_SHA256,
    "hashlib.md5": lambda: hashlib.md5(b"abc", usedforsecurity=False).hexdigest() == _ABC_MD5,
    "json.dumps": lambda: json.dumps(_PLAIN, sort_keys=True) == _WRITTEN,
    "json.loads": lambda: json.loads(_WRITTEN) == _PLAIN,
    "zlib.compress": lambda: zlib.decompress(zlib.compress(b"abc" * 9)) == b"abc" * 9,
    "zlib.crc32": lambda: zlib.crc32(b"abc") == _ABC_CRC32,
    "struct.pack": lambda: struct.unpack("<d", struct.pack("<d", 0.1)) == (0.1,),
    "math.sqrt": lambda: math.sqrt(4.0) == 2.0 and math.isfinite(1.0) and not math.isfinite(math.inf),
    "time.monotonic": lambda: math.isfinite(time.monotonic()) and time.monotonic() <= time.monotonic(),
    "time.perf_counter": lambda: math.isfinite(time.perf_counter()) and time.perf_counter() <= time.perf_counter(),
    "time.process_time": lambda: math.isfinite(time.process_time()) and time.process_time() <= time.process_time(),
    "builtins.sorted": lambda: builtins.sorted([2, 1, 3]) == [1, 2, 3],
    "builtins.len": lambda: builtins.len("abc") == 3,
    "builtins.round": lambda: builtins.round(2.5) == 2 and builtins.round(0.125, 2) == 0.12,
    "builtins.min": lambda: builtins.min(2, 1) == 1 and builtins.max(2, 1) == 2,
    "builtins.sum": lambda: builtins.sum([1, 2]) == 3,
    "builtins.abs": lambda: builtins.abs(-1) == 1,
    "builtins.hash": lambda: builtins.hash(7) == 7,
    "builtins.isinstance": lambda: builtins.isinstance(1, int) and not builtins.isinstance("1", int),
}


def wrong_answers() -> tuple[str, ...]:
    """The parts of Python's library that answer wrongly in this process, or not at all. Takes some 30 us."""
    return tuple(_wrong())


def _wrong() -> Iterator[str]:
    for name, answers in _ANSWERS.items():
        try:
            right = answers()
        except Exception:  # whatever the replacement raises
            right = False
        if right is not True:
            yield name


def complaint(names: tuple[str, ...], code: Iterable[str] = ()) -> str:
    """A sentence that says what is wrong, where modules under test changed it, and what to do."""
    place = next((f" at {place}" for place in places_of_change(names, code)), "")
    return (
        f"{', '.join(names)} of Python's library {'answers' if len(names) == 1 else 'answer'} wrongly: the code under "
        f"test has replaced it for the whole process{place}, so results of other tests, and of pytest, may be wrong: "
        "replace it in the code's own modules only, or restore it"
    )
