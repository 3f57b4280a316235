"""`--hri-break-on-violation`: a debugger at the instant of a violation, inside the code under test."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.extra.campaign.conftest import environment
from tests.plugin import project
from tests.plugin.ide import Client, under_an_ide

RUN = ("--hri-suite=rl", "--hri-strict", "-x", "-p", "no:cacheprovider")


def debugged(lamps: pytest.Pytester, commands: str, *options: str) -> str:
    """What a session says in which these commands are given to the debugger."""
    given = [sys.executable, "-m", "pytest", *RUN, *options]
    done = subprocess.run(
        given,
        cwd=lamps.path,
        env=environment(),
        timeout=60,
        check=False,
        input=commands,
        capture_output=True,
        text=True,
    )
    return done.stdout + done.stderr


@pytest.mark.slow
def test_it_stops_in_the_line_that_acted_while_time_stands_still(lamps: pytest.Pytester) -> None:
    asked = "p hri_state.time_s, hri_state.requirement\np hri_state.signals, hri_state.messages['wish']\np level\nc\n"
    said = debugged(lamps, f"where\n{asked}", "--hri-break-on-violation=R2")
    assert "> R2 is violated at 1.72 s: see hri_state; c continues, q ends the session >" in said
    assert f"> {lamps.path}/lamps/guide.py(19)serve()\n-> lamp.set(level)" in said
    assert "(1.715564, 'R2')" in said
    assert "({'lamp_level': 100.0}, {'level': 100.0, 'cellar': False})" in said
    assert "(Pdb) 100.0\n" in said
    assert "R2 Failed: The lamp shall never glare" in said
    assert "1 failed" in said


@pytest.mark.slow
def test_where_the_world_acts_it_stops_where_the_code_under_test_waits(lamps: pytest.Pytester) -> None:
    project.change(lamps.path, "conftest.py", "    def visitor():\n", "    def visitor():\n        lamp.set(90.0)\n")
    project.change(lamps.path, "conftest.py", '    run.kernel.spawn("visitor", visitor)\n', "")
    both = '    run.kernel.spawn("guide", run.measured(robot))\n'
    project.change(lamps.path, "conftest.py", both, f'{both}    run.kernel.spawn("visitor", visitor)\n')
    said = debugged(lamps, "p hri_state.nodes\nc\n", "--hri-break-on-violation=R2")
    assert "-> wish = wishes.wait(patience_s)" in said
    assert "('guide',)" in said


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (
            ("--hri-break-on-violation=R9",),
            "ERROR: --hri-break-on-violation=R9: no such requirement; there are: R1, R2, R3",
        ),
        (
            ("--hri-break-on-violation=R2", "-n", "1"),
            "ERROR: --hri-break-on-violation: a debugger needs a terminal, and workers have none*",
        ),
    ],
)
def test_bad_input(lamps: pytest.Pytester, options: tuple[str, ...], said: str) -> None:
    lamps.runpytest_subprocess(*RUN, *options).stderr.fnmatch_lines([said])


@pytest.mark.slow
@pytest.mark.parametrize("as_library", [False, True])
def test_an_ides_debugger_stops_in_the_code_under_test_also_where_it_shows_nothing_of_the_plugin(
    lamps: pytest.Pytester, tmp_path: Path, as_library: bool
) -> None:
    pytest.importorskip("debugpy")
    seen: list[object] = []

    def converse(client: Client) -> None:
        client.ask("initialize", adapterID="tests", pathFormat="path", linesStartAt1=True)
        client.ask("attach", justMyCode=True)
        for message in client.told():
            kind, body = message.get("event") or message.get("command"), message.get("body") or {}
            match kind:
                case "initialized":
                    client.ask("configurationDone")
                case "stopped":
                    client.ask("stackTrace", threadId=body["threadId"])
                case "stackTrace":
                    frames = [(frame["name"], Path(frame["source"]["path"]).name) for frame in body["stackFrames"]]
                    seen.extend(frames[:2])
                    client.ask("evaluate", expression="hri_state.time_s", frameId=body["stackFrames"][0]["id"])
                case "evaluate":
                    seen.append(body["result"])
                    client.ask("continue", threadId=1)
                case "terminated":
                    return

    given = ("-m", "pytest", *RUN, "--hri-break-on-violation=R2")
    roots = {"IDE_PROJECT_ROOTS": str(lamps.path)} if as_library else {}
    said = under_an_ide(given, lamps.path, tmp_path / "endpoints.json", converse, roots)
    assert seen == [("serve", "guide.py"), ("robot", "conftest.py"), "1.715564"]
    assert "R2 Failed: The lamp shall never glare" in said
