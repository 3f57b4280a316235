"""What attacks on the tool show: INTERNALERROR, tracebacks, silence, and sessions without an end.

    python -m studies.attacks [--kind hostile,models] [--only NAME,NAME]    # prints those that fail
    python -m studies.attacks --results FILE --page                         # resumes; the table of the page

An attack *holds* if the tool's answer is the right result or a located error, with a report, within a minute.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from pytest_hricdv._base.atomic_file import replace_file
from studies.attacks import FOLDER, LIMIT_S, Attack, attacks, judge
from studies.page import replace_figures, table

PAGE = FOLDER.parents[1] / "docs" / "studies" / "attacks.md"
COMMAND = "python -m studies.attacks --results FILE --page"
HEAD = ("kind", "attacks", "held", "failed")

ENDING = """

_calls = []


def _end(place):
    where, _, number = __import__("os").environ.get("END", "").partition(":")
    if where == place:
        __import__("os").kill(__import__("os").getpid(), int(number))


def pytest_runtest_logreport(report):
    if report.when == "call":
        _calls.append(report)
        _end(str(len(_calls)))


def pytest_sessionfinish(session):
    _end("finish")


def pytest_unconfigure(config):
    _end("unconfigure")
"""
"""In the project's conftest: `END=2:9` kills pytest after its second test."""


def run(attack: Attack, project: Path) -> dict[str, object]:
    """Run an attack in a folder of its own; returns what came."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as name:
        folder = Path(name) / "arm"
        if attack.is_project:
            shutil.copytree(project, folder)
        else:
            folder.mkdir()
        attack.write(folder)
        began_s, output, statuses = time.monotonic(), "", []
        for command in attack.script():
            status, text = _call(command, folder)
            output += f"$ {command}\n{text}"
            statuses.append(status)
        wrong = judge(attack, folder, output, statuses)
    took_s = round(time.monotonic() - began_s, 1)
    return {"kind": attack.kind, "name": attack.name, "wrong": wrong, "took_s": took_s, "statuses": statuses,
            "output": output[-6000:]}  # fmt: skip


def _call(command: str, folder: Path) -> tuple[int, str]:
    """The exit status and the output of a command; all of its processes are ended after `LIMIT_S`."""
    scripts = Path(sys.executable).parent
    environment = {**os.environ, "PATH": f"{scripts}:{os.environ['PATH']}"}
    with tempfile.TemporaryFile() as output:
        process = subprocess.Popen(["bash", "-c", command], cwd=folder, env=environment, stdin=subprocess.DEVNULL,
                                   stdout=output, stderr=subprocess.STDOUT, start_new_session=True)  # fmt: skip
        try:
            status = process.wait(LIMIT_S)
        except subprocess.TimeoutExpired:
            status = -9
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)  # what it has left behind, too
        process.wait()
        output.seek(0)
        return status, output.read().decode(errors="replace")


def make_project(folder: Path) -> Path:
    """The project that attacks begin with."""
    subprocess.run(
        [sys.executable, "-m", "pytest_hricdv", "init", str(folder), "--robot=arm"], check=True, capture_output=True
    )
    with (folder / "conftest.py").open("a", encoding="utf-8") as file:
        file.write(ENDING)
    return folder


def main() -> None:
    """Run attacks, and print or write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kind", default="", metavar="KINDS", help="of some kinds, such as hostile,models")
    parser.add_argument("--only", default="", metavar="NAMES", help="attacks of these names")
    parser.add_argument(
        "--results", type=Path, metavar="FILE", help="results so far (JSON); those in it do not run again"
    )
    parser.add_argument("--say", action="store_true", help="print what came")
    parser.add_argument("--page", action="store_true", help="write the table to the page")
    options = parser.parse_args()
    kinds, names = (list(filter(None, text.split(","))) for text in (options.kind, options.only))
    results: list[dict[str, object]] = []
    if options.results and options.results.exists():
        results = json.loads(options.results.read_text(encoding="utf-8"))
    done = {(each["kind"], each["name"]) for each in results}
    with tempfile.TemporaryDirectory() as name:
        project = make_project(Path(name) / "arm")
        for attack in attacks():
            if (kinds and attack.kind not in kinds) or (names and attack.name not in names):
                continue
            if (attack.kind, attack.name) in done:
                continue
            result = run(attack, project)
            results.append(result)
            print(f"{attack.kind}.{attack.name}: {result['wrong'] or 'held'} ({result['took_s']} s)", flush=True)
            if options.say:
                print(result["output"])
            if options.results:
                with replace_file(options.results) as part:
                    part.write_text(json.dumps(results, indent=1), encoding="utf-8")
    text = summary(results)
    print(text)
    if options.page:
        replace_figures(PAGE, COMMAND, text)


def summary(results: list[dict[str, object]]) -> str:
    """The table of the page."""
    rows = []
    for kind in (*sorted({str(each["kind"]) for each in results}), ""):
        of = [each for each in results if each["kind"] == kind or not kind]
        failed = sum(bool(each["wrong"]) for each in of)
        rows.append(
            [kind or "all", str(len(of)), str(len(of) - failed), f"{failed} ({100 * failed / max(len(of), 1):.1f} %)"]
        )
    return table(HEAD, rows)


if __name__ == "__main__":
    main()
