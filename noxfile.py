"""The commands of the Makefile for systems without make, such as Windows: `pipx run nox -s suite` and `-s test`.

nox is what many pytest plugins use for this: it makes an environment with the tools of the system that it runs on, and
runs the same commands there. What follows `--` is handed on to pytest.
"""

from __future__ import annotations

from pathlib import Path

import nox

nox.options.default_venv_backend = "venv"
nox.options.reuse_existing_virtualenvs = True
nox.options.sessions = ["suite"]


def install(session: nox.Session) -> None:
    """Install the project with its simulated world and the development tools."""
    groups = nox.project.dependency_groups(nox.project.load_toml("pyproject.toml"), "dev")
    session.install("--editable", ".[sim]", *groups)


@nox.session
def suite(session: nox.Session) -> None:
    """Learn tests from the BDI models and run each against the simulated world, on two workers."""
    session.install("--editable", ".[sim]")
    session.run("pytest", "--hri-suite=rl", "-n", "2", *session.posargs)


@nox.session
def test(session: nox.Session) -> None:
    """The project's own tests, without the long ones."""
    install(session)
    session.run("pytest", "-n", "2", "--dist", "worksteal", *session.posargs)


@nox.session
def lint(session: nox.Session) -> None:
    """Style, types, imports, models and workflows."""
    install(session)
    session.run("ruff", "check", ".")
    session.run("ruff", "format", "--check", ".")
    session.run("mypy")
    session.run("lint-imports")
    session.run("python", "-m", "pytest_hricdv.bdi", "lint", "models_bdi/table_assembly.mas2j")
    session.run("python", "-m", "studies.freshness")
    session.run("python", "-m", "studies.size", "--check")
    workflows = sorted(str(path) for path in Path(".github/workflows").glob("*.yml"))
    session.run("check-jsonschema", "--builtin-schema", "vendor.github-workflows", *workflows)
    session.run("check-jsonschema", "--builtin-schema", "vendor.citation-file-format", "CITATION.cff")


@nox.session
def docs(session: nox.Session) -> None:
    """The documentation as a site; a warning is an error. It needs the project and its own tools, nothing else."""
    groups = nox.project.dependency_groups(nox.project.load_toml("pyproject.toml"), "docs")
    session.install("--editable", ".", *groups)
    session.run("python", "-m", "sphinx", "--builder", "html", "--fail-on-warning", "--quiet", "docs", "docs/_build")
