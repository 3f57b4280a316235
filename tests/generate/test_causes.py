"""Which action of one actor makes another's wait: by messages, through other agents, by beliefs; and what is free."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.bdi import Environment, MultiAgentSystem
from pytest_hricdv.generate.causes import causes


def order(folder: Path, **agents: str) -> dict[str, tuple[str, ...]]:
    """The order between the lanes of `a` and `b` in a run of these agents, `action number: causes`."""
    (folder / "m.mas2j").write_text(f"MAS m {{ agents: {'; '.join(agents)}; }}", encoding="utf-8")
    for name, text in agents.items():
        (folder / f"{name}.asl").write_text(text.replace(". ", ".\n"), encoding="utf-8")
    system = MultiAgentSystem.load(folder / "m.mas2j", Environment())
    result = system.run(trace=True)
    assert result.trace is not None
    lanes = ("a", "b")
    numbered = [agent + ":" + action for agent, action in result.actions if agent in lanes]
    assert sorted(numbered) == sorted(set(numbered)), "each action once, so that the tests can name it"
    found = causes(result.trace, {name: system.program(name) for name in system.agents}, lanes)
    names = dict(enumerate(numbered, 1))
    return {names[number]: tuple(names[cause] for cause in before) for number, before in found.items()}


@pytest.mark.parametrize(
    ("agents", "expected"),
    [
        pytest.param(
            {"a": "!go. +!go <- one; .send(b, tell, seen).", "b": "+seen <- two."}, {"b:two": ("a:one",)}, id="told"
        ),
        pytest.param(
            {"a": "!go. +!go <- one; .send(b, achieve, help).", "b": "+!help <- two."},
            {"b:two": ("a:one",)},
            id="asked",
        ),
        pytest.param({"a": "!go. +!go <- one.", "b": "!go. +!go <- two."}, {}, id="strangers"),
        pytest.param(
            {"a": "!go. +!go <- .send(b, tell, seen); one.", "b": "+seen <- two."}, {}, id="told before it was done"
        ),
        pytest.param(
            {
                "a": "!go. +!go <- one; .send(robot, tell, called).",
                "robot": "+called <- drive; .send(b, tell, comes).",
                "b": "+comes <- two.",
            },
            {"b:two": ("a:one",)},
            id="through the robot",
        ),
        pytest.param(
            {
                "a": "!go. +!go <- !press; .send(b, tell, seen). +!press <- one.",
                "b": "!play. +!play <- two; .wait({+seen}); three. +seen.",
            },
            {"b:three": ("a:one",)},
            id="waited for, after an action that is free",
        ),
        pytest.param(
            {
                "a": "!go. +!go <- .wait(50); one; .send(b, tell, seen).",
                "b": "!play. +!play <- two; !stay; three. +!stay <- .wait({+seen}, 5000, _).",
            },
            {"b:three": ("a:one",)},
            id="waited for in a subgoal that has ended",
        ),
        pytest.param(
            {
                "a": "!go. +!go <- .wait(50); one; .send(b, tell, seen).",
                "b": "!play. +!play <- !look; two; .wait(200); three. +!look <- ?seen; .print(yes). -!look.",
            },
            {},
            id="named by a subgoal that had ended before",
        ),
        pytest.param(
            {
                "a": "!go. +!go <- one; .send(b, tell, seen).",
                "b": "!play. +!play : seen <- two. +!play <- .wait(100); !play.",
            },
            {"b:two": ("a:one",)},
            id="polled for in a context",
        ),
        pytest.param(
            {
                "a": "!go. +!go <- one; .send(b, tell, seen).",
                "b": "warned :- seen. !play. +!play : warned <- two. +!play <- .wait(100); !play.",
            },
            {"b:two": ("a:one",)},
            id="by a rule",
        ),
        pytest.param(
            {
                "a": "!go. +!go <- one; .send(b, tell, seen).",
                "b": "+seen <- +busy. +busy <- .wait(50). !play. +!play <- .wait(500); !late. +!late : busy <- two.",
            },
            {"b:two": ("a:one",)},
            id="by a belief of its own that came of it",
        ),
        pytest.param(
            {
                "a": "!go. +!go <- one; .send(b, tell, seen).",
                "b": "+seen. !play. +!play <- .wait(500); two.",
            },
            {},
            id="what is heard and does not matter orders nothing",
        ),
        pytest.param(
            {
                "a": "!go. +!go <- one; .send(b, tell, seen); .wait({+done}); three. +done.",
                "b": "+seen <- two; .send(a, tell, done).",
            },
            {"b:two": ("a:one",), "a:three": ("b:two",)},
            id="there and back",
        ),
        pytest.param(
            {
                "a": "!go. +!go <- one; two; .send(b, tell, seen).",
                "b": "+seen <- three; four.",
            },
            {"b:three": ("a:two",)},
            id="only what does not follow from the rest",
        ),
        pytest.param(
            {
                "a": "!go. !other. +!go <- one; .send(b, tell, seen). +!other <- two.",
                "b": "+seen <- three.",
            },
            {"b:three": ("a:one",)},
            id="another intention of the sender has nothing to do with it",
        ),
        pytest.param(
            {
                "a": "!go. +!go <- one; .broadcast(tell, seen).",
                "b": "+seen <- two.",
            },
            {"b:two": ("a:one",)},
            id="broadcast",
        ),
        pytest.param(
            {
                "a": "!go. +!go <- one; +ready(yes).",
                "b": "!play. +!play <- .wait(300); .send(a, askOne, ready(X), ready(X)); two.",
            },
            {"b:two": ("a:one",)},
            id="asked for",
        ),
        pytest.param(
            {
                "a": "!go. +!go <- one; .send(b, tell, seen); .wait(300); two; .send(b, untell, seen).",
                "b": "!play. +!play <- .wait(700); !late. +!late : not seen <- three.",
            },
            {"b:three": ("a:two",)},
            id="told no longer",
        ),
    ],
)
def test_what_comes_after_what(tmp_path: Path, agents: dict[str, str], expected: dict[str, tuple[str, ...]]) -> None:
    assert order(tmp_path, **agents) == expected
