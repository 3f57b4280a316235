"""The server of the Model Context Protocol, with the client of the SDK: in the process, and over standard streams."""

from __future__ import annotations

import asyncio
import json
import sys
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest

from pytest_hricdv.report.files import write
from tests.docs.page import blocks, write_files
from tests.report import sample

mcp: Any = pytest.importorskip("mcp")
READS = {"status", "causes", "open_points", "changes", "test", "requirement", "coverage"}
RUNS = {"run_suite", "run_actions", "run_beliefs", "replay", "shrink", "close"}


async def answer(client: Any, tool: str, **arguments: Any) -> Any:
    """What a tool says: an object, or the text of its error."""
    result = await client.call_tool(tool, arguments)
    text = result.content[0].text
    return text if result.is_error else json.loads(text)


def talk(project: Path, talking: Callable[[Any], Awaitable[Any]], *, allow_run: bool = False) -> Any:
    """Talk to a server in this process."""
    from pytest_hricdv.extra.answers.server import make_server

    async def main() -> Any:
        async with mcp.Client(make_server(project, allow_run=allow_run)) as client:
            return await talking(client)

    return asyncio.run(main())


def test_a_server_reads_only_unless_it_may_run(tmp_path: Path) -> None:
    async def tools(client: Any) -> set[str]:
        return {tool.name for tool in (await client.list_tools()).tools}

    assert talk(tmp_path, tools) == READS
    assert talk(tmp_path, tools, allow_run=True) == READS | RUNS


def test_answers_are_those_of_the_report(tmp_path: Path) -> None:
    report = sample.report(tests=3)
    write(report, tmp_path / "hri-report")

    async def ask_all(client: Any) -> list[Any]:
        return [
            await answer(client, "status"),
            await answer(client, "test", name=report.tests[0].id),
            await answer(client, "requirement", name="R3"),
            await answer(client, "requirement", name="R99"),
        ]

    status, test, requirement, unknown = talk(tmp_path, ask_all)
    assert status["testbench"] == "table-assembly"
    assert (test["id"], requirement["id"]) == (report.tests[0].id, "R3")
    assert "no requirement 'R99'" in unknown


def test_no_path_leads_out_of_the_project(tmp_path: Path) -> None:
    write(sample.report(), tmp_path / "elsewhere")
    (tmp_path / "project").mkdir()
    (tmp_path / "project" / "link").symlink_to(tmp_path / "elsewhere")

    async def ask_all(client: Any) -> list[Any]:
        paths = ("../elsewhere", str(tmp_path / "elsewhere"), "link", "hri-report")
        return [await answer(client, "status", report=path) for path in paths]

    *outside, missing = talk(tmp_path / "project", ask_all)
    assert all("is not in the project" in said for said in outside)
    assert "no such report" in missing


@pytest.mark.slow
def test_a_client_closes_the_tutorial(tmp_path: Path) -> None:
    """All that a scripted client knows is what the server says."""
    with_bug = [block for block in blocks("tutorial.md") if block.kind != "diff"]
    write_files(with_bug, tmp_path)
    (tmp_path / "test_own.py").unlink()
    command = ["-m", "pytest_hricdv.report", "mcp", str(tmp_path), "--allow-run"]

    async def main() -> list[Any]:
        from mcp.client.stdio import StdioServerParameters

        async with mcp.Client(StdioServerParameters(command=sys.executable, args=command)) as client:
            said = [await answer(client, "run_suite", tests=8), await answer(client, "causes")]
            said.append(await answer(client, "test", name=said[1]["items"][0]["tests"][0]))
            lines = [action["line"] for action in said[2]["actions"]]
            said.append(await answer(client, "run_actions", actions=lines))
            said.append(await answer(client, "run_actions", actions=["# no action"]))
            said.append(await answer(client, "run_beliefs", beliefs=["two_cups", "brings_cup", "patient"]))
            said.append(await answer(client, "run_beliefs", beliefs=["two_mugs"]))
            said.append(await answer(client, "shrink", file=said[2]["replay"]))
            return [*said, await answer(client, "close", runs=60), await answer(client, "open_points")]

    ran, causes, failing, again, refused, believed, unknown, shrunk, closed, left = asyncio.run(main())
    assert again["requirements"]["R1"]["failed"] == 1
    assert "expected at least one, each a line" in refused
    assert sum(believed["tests"].values()) == 1
    assert "unknown belief: 'two_mugs'; nearest: two_cups" in unknown
    assert (shrunk["failed"], sum(shrunk["tests"].values())) == (True, 1)
    assert (ran["failed"], closed["failed"]) == (True, True)
    assert causes["items"][0]["requirements"] == ["R1"]
    assert failing["verdicts"]["R1"] == "Failed"
    assert left["total"] == 0
