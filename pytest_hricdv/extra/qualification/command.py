"""`hricdv qualify`: checks this installation by known answers.

Runs sessions of a small robot with and without seeded bugs, and monitors with verdicts and margins computed by
hand, and writes a page to sign. The exit status is 1 if an answer is not the known one. It takes two minutes.
"""

from __future__ import annotations

import argparse
import platform
import subprocess
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from tempfile import TemporaryDirectory

from pytest_hricdv._base.atomic_file import write_text
from pytest_hricdv._base.error_text import error_text
from pytest_hricdv._base.message import harmless_line
from pytest_hricdv.extra.qualification.known_answers import KNOWN_ANSWERS, Workshop, WrongAnswerError
from pytest_hricdv.report.html import standalone

OK, WRONG = 0, 1
AT_ONCE = 2
"""Maximum number of sessions that run at the same time."""
PACKAGES = ("pytest-hricdv", "pytest", "pytest-xdist", "coverage", "greenlet", "msgspec", "pybullet", "mujoco-core")
"""Packages whose versions are on the page."""


def add_command(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command `qualify` to those of `hricdv`."""
    purpose = "check this installation by known answers, and write a page to sign"
    parser = commands.add_parser("qualify", help=purpose, description=__doc__)
    parser.set_defaults(do=_do)
    page = Path("qualification.html")
    parser.add_argument("-o", "--output", type=Path, default=page, metavar="FILE", help=f"the page (default {page})")


def _do(options: argparse.Namespace) -> int:
    results = []
    with TemporaryDirectory() as folder:
        for title, problem in qualify(Path(folder), KNOWN_ANSWERS):
            results.append((title, problem))
            print(harmless_line(f"WRONG {title}: {problem}" if problem else f"ok    {title}"), flush=True)
    wrong = sum(bool(problem) for _, problem in results)
    write_text(options.output, page(results))
    print(f"{len(results) - wrong} of {len(results)} answers are the known ones: {options.output}")
    return WRONG if wrong else OK


def qualify(folder: Path, answers: Sequence[tuple[str, Callable[[Workshop], None]]]) -> Iterator[tuple[str, str]]:
    """Check answers; yields each title with what is wrong, or an empty string.

    Args:
        folder: empty, for the sessions.
        answers: titles, and the functions that check them.
    """
    workshop = Workshop(folder)
    with ThreadPoolExecutor(AT_ONCE) as pool:  # each session is a process of its own
        problems = pool.map(lambda answer: _problem(workshop, answer[1]), answers)
        for (title, _), problem in zip(answers, problems, strict=True):
            yield title, problem


def _problem(workshop: Workshop, check: Callable[[Workshop], None]) -> str:
    try:
        check(workshop)
    except WrongAnswerError as error:
        return str(error)
    except (Exception, subprocess.SubprocessError) as error:  # whatever is broken is a fault of this answer
        return error_text(error)
    return ""


def page(results: Sequence[tuple[str, str]]) -> str:
    """The page to sign, for the screen and for print."""
    facts = [f"Python {platform.python_version()}", platform.platform(), *_versions()]
    wrong = sum(bool(problem) for _, problem in results)
    return standalone(__package__, "qualification.html.jinja", results=results, facts=facts, known=len(results) - wrong)


def _versions() -> Iterator[str]:
    for name in PACKAGES:
        try:
            yield f"{name} {version(name)}"
        except PackageNotFoundError:
            continue
