"""What importing the code under test covers, measured in a separate process.

Import lines run once per process: in the first test, or before any test when a conftest imports early. A fresh process
gives the same result whatever the order of tests, the worker, and the imports of the project.
"""

from __future__ import annotations

import importlib
import json
import pkgutil
import subprocess
import sys
from typing import Any

from pytest_hricdv._base.hash_seed import environment_of_child
from pytest_hricdv.coverage.code_map import Bits, CodeMap, CoverageError

TIMEOUT_S = 120
"""A hundred times what the controller of the table takes; only an import that waits for something takes longer."""


def import_bits(code: CodeMap, *, before: tuple[str, ...] = ()) -> Bits:
    """The statements and branches that run when every module under test is imported.

    Args:
        before: functions without arguments, as "package.module:name", that are called before.

    Raises:
        CoverageError: a module cannot be imported; the last line of its traceback is given.
    """
    files = [str(file.path) for file in code.files]
    task = {"packages": code.packages, "files": files, "before": before}
    try:
        process = subprocess.run(
            [sys.executable, "-m", __name__],
            input=json.dumps(task),
            capture_output=True,
            encoding="utf-8",  # JSON is plain ASCII; of the errors only a line is shown
            errors="replace",
            env=environment_of_child(),
            timeout=TIMEOUT_S,
        )
    except subprocess.TimeoutExpired:
        raise CoverageError(f"importing the code under test took more than {TIMEOUT_S} s") from None
    if process.returncode:
        last = process.stderr.strip().splitlines()[-1:]
        raise CoverageError(f"the code under test cannot be imported: {''.join(last)}")
    answer = json.loads(process.stdout.splitlines()[-1])
    return code.translated(answer["lines"], {name: map(tuple, arcs) for name, arcs in answer["arcs"].items()})


def import_all(packages: tuple[str, ...]) -> None:
    """Import every module of the packages."""
    for package in packages:
        module = importlib.import_module(package)
        for submodule in pkgutil.walk_packages(getattr(module, "__path__", ()), f"{package}."):
            if not submodule.name.endswith("__main__"):
                importlib.import_module(submodule.name)


def main() -> None:
    """Measure the imports named on standard input; the answer is the last line of standard output."""
    import coverage

    task = json.load(sys.stdin)
    for name in task["before"]:
        pkgutil.resolve_name(name)()
    measurement = coverage.Coverage(data_file=None, config_file=False, branch=True, include=task["files"])
    measurement.set_option("run:core", "ctrace")
    measurement.start()
    import_all(tuple(task["packages"]))
    measurement.stop()
    data = measurement.get_data()
    answer: dict[str, dict[str, Any]] = {
        "lines": {name: data.lines(name) or [] for name in task["files"]},
        "arcs": {name: data.arcs(name) or [] for name in task["files"]},
    }
    print(json.dumps(answer))


if __name__ == "__main__":
    main()
