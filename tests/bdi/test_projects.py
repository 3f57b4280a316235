"""Project files: what counts in them, and what is only warned about."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.bdi import BdiSyntaxError, Environment, MultiAgentSystem
from pytest_hricdv.bdi.__main__ import main

HELLO = "!start. +!start <- .my_name(Me); .print(Me)."


def _project(folder: Path, text: str, environment: Environment | None = None) -> MultiAgentSystem:
    (folder / "mas.mas2j").write_text(text, encoding="utf-8")
    return MultiAgentSystem.load(folder / "mas.mas2j", environment)


@pytest.mark.parametrize("count", ["0", "1.5", "10001", "9" * 5000])
def test_number_of_copies_must_be_whole_and_positive(tmp_path: Path, count: str) -> None:
    with pytest.raises(BdiSyntaxError, match=rf"mas\.mas2j:1:\d+: expected a whole number .* found '{count[:20]}'"):
        _project(tmp_path, f"MAS m {{ agents: ann #{count}; }}")


@pytest.mark.parametrize("source", ["other.asl", "./sub/other.asl", "sub/other", '"sub/other.asl"', "sub\\other.asl"])
def test_source_may_have_another_name_and_folder(tmp_path: Path, source: str) -> None:
    (tmp_path / "sub").mkdir()
    for folder in (tmp_path, tmp_path / "sub"):
        (folder / "other.asl").write_text(HELLO)
    assert _project(tmp_path, f"MAS m {{ agents: ann {source}; }}").run().prints == ["[ann] ann"]


def test_beliefs_and_goals_of_the_project_come_before_those_of_the_source(tmp_path: Path) -> None:
    (tmp_path / "ann.asl").write_text("p(1). p(2). !b. +!a <- .print(a). +!b <- .findall(X, p(X), L); .print(L).")
    system = _project(tmp_path, 'MAS m { agents: ann [beliefs="p(3),p(4)", goals="a"]; }')
    assert system.run().prints == ["[ann] a", "[ann] [1,2,4,3]"]


def test_what_has_no_effect_is_warned_about_once(tmp_path: Path) -> None:
    for name in ("ann", "bob"):
        (tmp_path / f"{name}.asl").write_text(HELLO)
    text = """MAS m {
      infrastructure: Jade
      environment: my.World(3, "x") at "host"
      executionControl: jason.Control
      agents:
        ann [events=requeue, nrcbp=1] agentClass my.Agent;
        bob [events=requeue] agentClass my.Agent beliefBaseClass my.Base(1) #2;
      directives: d = my.Directive;
      classpath: "lib/*.jar";
    }"""
    system = _project(tmp_path, text)
    assert system.agents == ("ann", "bob1", "bob2")
    path = tmp_path / "mas.mas2j"
    assert system.warnings == (
        f"{path}:2:7: ignored: infrastructure Jade: agents always run in one process, in turn",
        f"{path}:4:7: ignored: section executionControl",
        f"{path}:6:14: ignored: option events of agents",
        f"{path}:6:39: ignored: agentClass of agents",
        f"{path}:7:50: ignored: beliefBaseClass of agents",
        f"{path}:8:7: ignored: section directives",
        f"{path}: ignored: environment my.World: without a Python environment every action succeeds",
    )
    assert len(_project(tmp_path, text, Environment()).warnings) == len(system.warnings) - 1


def test_warnings_of_the_project_are_shown_by_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "ann.asl").write_text(HELLO)
    _project(tmp_path, "MAS m { infrastructure: Jade agents: ann; }")
    assert main(["run", str(tmp_path / "mas.mas2j")]) == 0
    assert "1:9: ignored: infrastructure Jade" in capsys.readouterr().err
