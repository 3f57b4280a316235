"""The seed of Python's hashes: what it is in a process, whatever its variable says, and in those that it starts."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from pytest_hricdv._base.hash_seed import environment_of_child, hand_to_children

ROOT = Path(__file__).parents[2]
SAY = "from pytest_hricdv._base.hash_seed import *; print(own_hash_seed(), hash_seed_of_children())"


def seeds(variable: str | None, *options: str, before: str = "") -> list[str]:
    """A fresh process's own seed, and that of its children."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONHASHSEED"}
    environment |= {} if variable is None else {"PYTHONHASHSEED": variable}
    code = f"import sys; sys.path.insert(0, {str(ROOT)!r})\n{before}\n{SAY}"
    return subprocess.check_output([sys.executable, *options, "-c", code], env=environment, text=True).split()


@pytest.mark.parametrize("seed", ["0", "1", "42", "4294967295"])
def test_a_seed_of_the_variable_is_the_processs_own_and_its_childrens(seed: str) -> None:
    assert seeds(seed) == [seed, seed]


@pytest.mark.parametrize("variable", [None, "", "random"])
def test_without_a_seed_it_is_random_and_children_get_zero(variable: str | None) -> None:
    assert seeds(variable) == ["random", "0"]


@pytest.mark.parametrize("seed", ["0", "42"])
def test_a_seed_that_was_set_after_python_had_started_is_not_believed_but_holds_for_children(seed: str) -> None:
    assert seeds(None, before=f"import os; os.environ['PYTHONHASHSEED'] = '{seed}'") == ["random", seed]


def test_a_childs_environment_has_its_seed_and_nothing_of_coverage(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COV_CORE_SOURCE", "hall")
    environment = environment_of_child({"LAMP": "on"}, path=("a", "", "b"), hash_seed="7")
    assert "COV_CORE_SOURCE" not in environment
    assert (environment["LAMP"], environment["PYTHONHASHSEED"]) == ("on", "7")
    assert environment["PYTHONPATH"] == os.pathsep.join(("a", "b"))


@pytest.mark.parametrize("before", [None, "random"])
def test_what_is_put_into_the_environment_for_children_is_taken_back(
    monkeypatch: pytest.MonkeyPatch, before: str | None
) -> None:
    monkeypatch.delenv("PYTHONHASHSEED", raising=False)
    if before is not None:
        monkeypatch.setenv("PYTHONHASHSEED", before)
    undo = hand_to_children()
    assert os.environ["PYTHONHASHSEED"].isdigit()
    undo()
    assert os.environ.get("PYTHONHASHSEED") == before
