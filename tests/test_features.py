"""Each optional feature can be deleted: its folder and its line in the list. The rest imports and runs tests."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import pytest_hricdv
from pytest_hricdv.registry import FEATURES, offers
from pytest_hricdv.skeleton.skeleton import Skeleton

PACKAGE = Path(pytest_hricdv.__file__).parent

QUICK = "--hri-no-cov -p no:html -p no:metadata -p no:allure_pytest -p no:cov -p no:hypothesispytest -p no:playwright"
"""Other plugins take longer to load than the tests to run, and the audit starts processes."""

PROGRAM = """
import importlib, pkgutil, sys
import pytest, pytest_hricdv

sys.modules.update(dict.fromkeys(("distributed", "pyarrow", "matplotlib", "rclpy")))  # they load slowly

for module in pkgutil.walk_packages(pytest_hricdv.__path__, "pytest_hricdv."):
    if module.name.startswith("pytest_hricdv.skeleton.") and module.name.count(".") > 2:
        continue
    try:
        importlib.import_module(module.name)
    except ModuleNotFoundError as error:
        if error.name.startswith("pytest_hricdv"):
            raise
sys.exit(pytest.main(["-q", "-p", "no:cacheprovider", "-p", "no:xdist", "--hri-tests=2"]))
"""
"""Imports each module, but for those that need a package which is missing; then runs the project's tests."""


def parts(feature: str) -> tuple[Path, ...]:
    """What goes with a feature: its folder, and the module of its public names or command, where it has one."""
    return PACKAGE / "extra" / feature, PACKAGE / f"{feature}.py"


def importers(feature: str) -> set[str]:
    """The parts of the package that import a feature, anywhere in a module: a feature, or a module of the core."""
    pattern = re.compile(
        rf"^\s*(?:from|import) pytest_hricdv\.extra(?:\.{feature}\b| import .*\b{feature}\b)", re.MULTILINE
    )
    own = parts(feature)
    users = set()
    for path in PACKAGE.rglob("*.py"):
        if not any(path.is_relative_to(part) for part in own) and pattern.search(path.read_text(encoding="utf-8")):
            names = path.relative_to(PACKAGE).parts
            users.add(names[1] if names[0] == "extra" else "/".join(names))
    return users


def copy_without(features: tuple[str, ...], folder: Path) -> None:
    """Make a package without these features, of links: it is quick, and the bytecode is there already."""
    left_out = {part for feature in features for part in parts(feature)}
    for path in [*PACKAGE.iterdir(), *(PACKAGE / "extra").iterdir()]:
        target = folder / "pytest_hricdv" / path.relative_to(PACKAGE)
        target.parent.mkdir(parents=True, exist_ok=True)
        if path not in left_out and path.name not in ("extra", "registry.py", "__pycache__"):
            target.symlink_to(path)
    registry = (PACKAGE / "registry.py").read_text(encoding="utf-8")
    for feature in features:
        registry, count = re.subn(rf'^ +"{feature}": \(.*?\),.*\n', "", registry, flags=re.MULTILINE)
        assert count == 1
    (folder / "pytest_hricdv" / "registry.py").write_text(registry, encoding="utf-8")


@pytest.mark.parametrize("feature", FEATURES)
def test_nothing_imports_it(feature: str) -> None:
    assert importers(feature) == set()


@pytest.mark.parametrize(("role", "name"), [("feature", "FEATURE"), ("execution", "EXECUTION"), ("view", "VIEW")])
def test_each_public_method_overrides_one_of_the_base_class(role: str, name: str) -> None:
    for offered in offers(role, name):
        own, *bases = type(offered).__mro__
        names = {method for base in bases for method in vars(base)}
        assert [method for method in vars(own) if not method.startswith("_") and method not in names] == []


@pytest.mark.parametrize(
    "features",
    [
        pytest.param(tuple(FEATURES), id="all"),
        *(pytest.param((feature,), id=feature, marks=pytest.mark.slow) for feature in FEATURES),
    ],
)
def test_without_it_each_module_imports_and_tests_run(features: tuple[str, ...], tmp_path: Path) -> None:
    project = tmp_path / "project"
    Skeleton("robot", "person").write(project)
    copy_without(features, tmp_path / "package")
    options = QUICK if "audit" in features else f"{QUICK} --hri-audit=off"
    environment = os.environ | {"PYTHONPATH": str(tmp_path / "package"), "PYTEST_ADDOPTS": options}
    command = [sys.executable, "-c", PROGRAM]
    done = subprocess.run(command, cwd=project, env=environment, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    assert not re.search(rf"pytest_hricdv/extra/({'|'.join(features)})/", done.stderr)
