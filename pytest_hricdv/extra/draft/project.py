"""The files of a draft, and how they are written."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from pytest_hricdv._base import atomic_file
from pytest_hricdv.extra.draft.conftest_text import conftest
from pytest_hricdv.extra.draft.drafted import Draft
from pytest_hricdv.extra.draft.model_text import mas2j, meta, person, robot
from pytest_hricdv.extra.draft.ports_text import ports
from pytest_hricdv.extra.draft.readme_text import readme
from pytest_hricdv.extra.draft.requirements_text import requirements
from pytest_hricdv.extra.draft.sources import DraftError
from pytest_hricdv.extra.draft.world_text import world

_HOST = '''"""The host test: runs once for each generated test."""

from __future__ import annotations

from typing import Any


def test_{robot}(hri_case: Any) -> None:
    """One generated test."""
    hri_case.check(hri_case.run())
'''


_SIZES = """# TODO: more tests and runs reach more, and take longer.
hri_tests = 30
hri_close_runs = 60
"""


def files(draft: Draft) -> Iterator[tuple[str, str]]:
    """Name, relative to the project's folder, and content of each file."""
    yield "conftest.py", conftest(draft)
    yield "world.py", world(draft)
    yield "ports.py", ports(draft)
    yield f"models/{draft.robot}.mas2j", mas2j(draft)
    yield "models/meta.asl", meta(draft)
    yield f"models/{draft.person}.asl", person(draft)
    if draft.things:
        yield "models/robot.asl", robot(draft)
    yield "requirements.toml", requirements(draft)
    yield f"test_{draft.robot}.py", _HOST.replace("{robot}", draft.robot)
    yield ("README.md" if not (draft.folder / "README.md").exists() else "README-hri.md"), readme(draft)
    root = os.path.relpath(draft.findings.root, draft.folder)
    if root != ".":
        yield "mypy.ini", f"[mypy]\nmypy_path = {root}\nignore_missing_imports = true\n"
    yield "pytest.ini", f"[pytest]\npythonpath = .{'' if root == '.' else ' ' + root}\nhri_suite = rl\n{_SIZES}"


def check(draft: Draft, folder: Path) -> None:
    """Raises DraftError where a file of the draft exists, or a module of the code has its name."""
    for name, _ in files(draft):
        if (folder / name).exists():
            raise DraftError(
                f"{folder / name} exists: nothing was written; choose another folder: init FOLDER --from ..."
            )
    taken = {"world", "ports", "conftest"} & set(draft.findings.code)
    if taken:
        raise DraftError(f"the code has a module {min(taken)!r}, which is the name of a file of the draft; rename it")


def write(draft: Draft, folder: Path) -> tuple[str, ...]:
    """Write all files; returns their names.

    Raises:
        DraftError: a file exists, then none is written; or the folder cannot be written.
    """
    texts = dict(files(draft))
    check(draft, folder)
    try:
        for name, text in texts.items():
            atomic_file.write_text(folder / name, text)
    except OSError as error:
        raise DraftError(f"{folder}: cannot be written: {error.strerror or error}") from None
    return tuple(texts)
