"""Follows the imports of a session from before its conftests, so that their coverage needs no second import.

`plugin` calls `follow_imports` before it is known what the code under test is. So all modules of the project and of its
`pythonpath` are followed, and those of installed packages once the testbench has named them. `Collection` makes the
testbench within `base_imports`, and `RunContext` measures with the resulting `ImportCoverage`.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import ModuleType
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from pytest_hricdv.coverage.import_coverage import ImportCoverage

IMPORTS = pytest.StashKey["ImportCoverage"]()
"""Key of the `ImportCoverage` in `config.stash`, in a session that measures the code under test."""


def is_wanted(config: pytest.Config, args: list[str]) -> bool:
    """Whether a session is likely to run generated tests and to measure them, before its options are read."""
    namespace = config.known_args_namespace
    if getattr(namespace, "hri_no_cov", None):
        return False
    asked = getattr(namespace, "hri_suite", None) or getattr(namespace, "hri_replay", None)
    return bool(asked or config.getini("hri_suite") or any(arg.startswith("--hri-") for arg in args))


def follow_imports(config: pytest.Config) -> ImportCoverage:
    """Follow the imports of this process until the session ends."""
    from pytest_hricdv.coverage.import_coverage import ImportCoverage  # a run without a suite does not load it

    if IMPORTS not in config.stash:
        folders = [config.rootpath]
        with suppress(ValueError):  # switched off, by -p no:python_path
            folders += config.getini("pythonpath")
        imports = config.stash[IMPORTS] = ImportCoverage(*dict.fromkeys(folder.resolve() for folder in folders))
        imports.watch.install()
        config.add_cleanup(imports.watch.uninstall)
    return config.stash[IMPORTS]


def follow_no_longer(config: pytest.Config) -> None:
    """Stop following imports: an ini file, read after the first imports, says that nothing is measured."""
    if IMPORTS in config.stash:
        config.stash[IMPORTS].watch.uninstall()
        del config.stash[IMPORTS]


@contextmanager
def base_imports(config: pytest.Config, conftest: str) -> Iterator[None]:
    """While the testbench is made, count its imports as imports of each of its tests.

    Args:
        conftest: name of the module that makes it; what it has imported at its top belongs to it.
    """
    imports = config.stash.get(IMPORTS, None)
    if imports is None:
        yield
        return
    with imports.watch.note_imports() as asked:
        yield
    values = vars(sys.modules.get(conftest, ModuleType(conftest))).values()
    modules = {value.__name__ if isinstance(value, ModuleType) else _module_of(value) for value in values}
    imports.base |= asked | modules


def _module_of(value: object) -> str:
    module = getattr(value, "__module__", "")
    return module if isinstance(module, str) else ""
