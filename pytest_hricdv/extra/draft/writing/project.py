"""The files of a draft, and how they are written."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from pytest_hricdv._base import atomic_file
from pytest_hricdv.extra.draft.reading.sources import DraftError
from pytest_hricdv.extra.draft.writing.drafted import Draft
from pytest_hricdv.extra.draft.writing.model import mas2j, meta, person, robot
from pytest_hricdv.extra.draft.writing.ports import ports
from pytest_hricdv.extra.draft.writing.readme import readme
from pytest_hricdv.extra.draft.writing.requirements import requirements
from pytest_hricdv.extra.draft.writing.ros_testbench import ros_conftest
from pytest_hricdv.extra.draft.writing.testbench import conftest
from pytest_hricdv.extra.draft.writing.world import world

_HOST = '''"""The host test: runs once for each generated test."""

from __future__ import annotations

from typing import Any


def test_{robot}(hri_case: Any) -> None:
    """One generated test."""
    hri_case.check(hri_case.run())
'''


_SIZES = """# TODO: more tests and runs reach more, and take longer.
hri_tests = {tests}
hri_close_runs = {runs}
"""
_ISOLATES = """\
# In the first runs a test left a state to the next (a variable of a module?). So each has its own process.
hri_isolate = true
"""
_NO_WAIVERS = """\
# {place} is waived as unreachable, and first runs executed it: the waivers of the code are of another testbench.
hri_no_waivers = true
"""
_TESTS, _RUNS = 30, 60
"""Tests of the suite `rl`, runs of a closing loop (chosen: less than two minutes, with the first runs)."""
_NODE_TESTS, _NODE_RUNS = 20, 30
"""The same for nodes of ROS 2 (chosen: likewise; their timers make runs longer)."""


def files(draft: Draft) -> Iterator[tuple[str, str]]:
    """Name, relative to the project's folder, and content of each file."""
    if draft.ros is not None:
        yield "conftest.py", ros_conftest(draft, draft.ros)
    else:
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
    tests, runs = (_TESTS, _RUNS) if draft.ros is None else (_NODE_TESTS, _NODE_RUNS)
    sizes = _SIZES.format(tests=draft.sizes.get("rl", tests), runs=draft.sizes.get("closure", runs))
    isolates = (_ISOLATES if draft.isolates else "") + (
        _NO_WAIVERS.format(place=draft.no_waivers) if draft.no_waivers else ""
    )
    folders = [os.path.relpath(root, draft.folder) for root in (draft.findings.root, *draft.findings.roots)]
    roots = [root for root in folders if root != "."]
    if roots:
        yield "mypy.ini", f"[mypy]\nmypy_path = {':'.join(roots)}\nignore_missing_imports = true\n"
    lines = [f"  {name} in {suite}: no test came to it in the first runs" for name, suite in draft.untriggered.items()]
    allowed = "\n".join(["hri_allow_nc =", *lines, ""]) if lines else ""
    yield "pytest.ini", f"[pytest]\npythonpath = {' '.join(['.', *roots])}\nhri_suite = rl\n{sizes}{isolates}{allowed}"


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
