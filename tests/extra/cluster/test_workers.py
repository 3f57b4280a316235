"""Questions to workers of this machine: real ones of Dask, and a service that is a few lines long."""

from __future__ import annotations

import os
import subprocess
import sys
from collections import deque
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks import lost_workers
from pytest_hricdv.extra.cluster.address import Address, ClusterError
from pytest_hricdv.extra.cluster.cluster import Cluster, Lost, Question, connected
from pytest_hricdv.extra.cluster.service import Answer, Service
from tests.extra.campaign.conftest import environment

ECHO = """
import json, os, sys, time

job = json.loads(sys.stdin.readline())
print(json.dumps({"project": job["project"], "versions": {"echo": "1"}}), end="\\n\\n", flush=True)
for line in sys.stdin:
    for word in json.loads(line):
        if word == "crash":
            os.abort()
        if word == "hang":
            time.sleep(60)  # what is tried: a service that gives no sign of life
        if word == "hash seed":
            word = os.environ["PYTHONHASHSEED"]
        print(json.dumps(word + "!"), flush=True)
    print(flush=True)
"""
PROJECT = {"robot.py": "0123456789abcdef"}


@pytest.fixture(scope="module")
def echo(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The folder of a module `echo_service`, which answers each word of a question."""
    folder = tmp_path_factory.mktemp("echo")
    (folder / "echo_service.py").write_text(ECHO, encoding="utf-8")
    sys.path.insert(0, str(folder))
    yield folder
    sys.path.remove(str(folder))


@pytest.fixture(scope="module")
def said() -> list[str]:
    """What the cluster told."""
    return []


@pytest.fixture(scope="module")
def cluster(echo: Path, said: list[str]) -> Iterator[Cluster]:
    """Two workers of this machine."""
    with connected(Address(workers=2), said.append) as made:
        yield made


def service(echo: Path, *, has: str = "0123456789abcdef", silent_s: float = 20.0) -> Service:
    """The service; its processes say that they have this project."""
    job = f'{{"project": {{"robot.py": "{has}"}}}}'.encode()
    return Service("echo_service", job, str(echo), PROJECT, silent_s)


def ask(cluster: Cluster, asked: Service, *questions: str) -> dict[str, Answer | Lost]:
    """Key -> answer to questions, each a JSON list of words."""
    queue = deque(Question(text, text.encode()) for text in questions)
    return {question.key: answer for question, answer in cluster.answers(asked, queue)}


def lines(answer: Answer | Lost) -> list[str]:
    """What an answer says."""
    assert isinstance(answer, Answer)
    return [line.decode().strip() for line in answer.lines]


@pytest.mark.slow
def test_each_question_is_answered_once(cluster: Cluster, echo: Path) -> None:
    texts = [f'["{number}", "again"]' for number in range(20)]
    found = ask(cluster, service(echo), *texts)
    assert {key: lines(answer) for key, answer in found.items()} == {
        text: [f'"{number}!"', '"again!"'] for number, text in enumerate(texts)
    }
    addresses = {answer.worker.address for answer in found.values() if isinstance(answer, Answer)}
    assert len(addresses) == 2
    assert all(isinstance(answer, Answer) and answer.worker.versions == {"echo": "1"} for answer in found.values())


def test_a_process_that_crashes_costs_no_worker(cluster: Cluster, echo: Path) -> None:
    found = ask(cluster, service(echo), '["one", "crash", "two"]', '["three"]', '["four"]')
    crashed = found['["one", "crash", "two"]']
    assert lines(crashed) == ['"one!"']
    assert isinstance(crashed, Answer)
    assert crashed.problem == "ended by SIGABRT"
    assert lines(found['["three"]']) == ['"three!"']
    assert cluster.threads == 2


@pytest.mark.slow
def test_a_process_that_is_silent_for_too_long_is_ended(cluster: Cluster, echo: Path) -> None:
    (answer,) = ask(cluster, service(echo, silent_s=2.0), '["hang"]').values()
    assert isinstance(answer, Answer)
    assert answer.problem == "no sign of life for 2 s"


def test_a_worker_with_another_project_is_refused_and_named(echo: Path) -> None:
    said: list[str] = []
    refused = pytest.raises(ClusterError, match=r"no worker can be asked: tcp://.*robot\.py changed")
    with connected(Address(workers=1), said.append) as made, refused:
        ask(made, service(echo, has="fedcba9876543210"), '["one"]')
    assert len(said) == 1
    assert said[0].startswith("worker tcp://127.0.0.1:")
    assert f"its project in {echo} is another one: robot.py changed" in said[0]


def test_a_service_that_cannot_begin_is_said_with_its_own_words(echo: Path) -> None:
    missing = Service("no_such_module", b"{}", str(echo), {}, 20.0)
    refused = pytest.raises(ClusterError, match=r"it cannot begin: .*No module named no_such_module")
    with connected(Address(workers=1), [].append) as made, refused:
        ask(made, missing, '["one"]')


@pytest.mark.slow
def test_workers_that_are_killed_are_replaced_and_nothing_is_missing(echo: Path) -> None:
    told: list[int] = []

    def kill_one() -> None:
        if len(told) < 3:
            # Both may be gone just now, or on their way out: the next one that comes is killed then.
            workers = made.connection.client.run(os.getpid, on_error="ignore")
            for process in [*workers.values()][:1]:
                told.append(process)
                os.kill(process, 9)

    with connected(Address(workers=2), [].append) as made:
        queue = deque(Question(str(number), f'["{number}"]'.encode()) for number in range(30))
        found = [
            (question.key, lines(answer)) for question, answer in made.answers(service(echo), queue, b"", kill_one)
        ]
    assert sorted(found) == sorted((str(number), [f'"{number}!"']) for number in range(30))
    assert len(told) == 3


@pytest.mark.slow
def test_workers_of_this_machine_that_do_not_come_back_are_started_anew(
    echo: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pytest_hricdv.extra.cluster.cluster.WAIT_FOR_LOCAL_S", 0.5)
    said: list[str] = []
    with connected(Address(workers=1), said.append) as made:
        made.connection._local.scale(0)
        while made.connection.client.scheduler_info()["workers"]:
            pass
        assert lines(ask(made, service(echo), '["one"]')['["one"]']) == ['"one!"']
    assert said == ["the workers of this machine are gone: others are started"]


def test_a_worker_with_other_versions_is_refused_and_named(echo: Path, tmp_path: Path) -> None:
    older = tmp_path / "msgspec-0.0.1.dist-info" / "METADATA"
    older.parent.mkdir()
    older.write_text("Metadata-Version: 2.1\nName: msgspec\nVersion: 0.0.1\n", encoding="utf-8")
    with lost_workers.cluster(0) as scheduler:
        scheduler.keep()
        worker = [
            sys.executable,
            "-m",
            "distributed.cli.dask_worker",
            scheduler.address,
            "--no-nanny",
            "--no-dashboard",
        ]
        path = os.pathsep.join([str(tmp_path), environment()["PYTHONPATH"]])
        given = {**environment(), "PYTHONPATH": path}
        with subprocess.Popen(worker, env=given, **lost_workers.QUIET) as process:  # type: ignore[call-overload]
            said: list[str] = []
            with pytest.raises(ClusterError, match=r"no worker can be asked: .*msgspec .*, now 0\.0\.1"):
                connected(Address(scheduler.address), said.append).__enter__()
            process.kill()
    assert len(said) == 1
    assert "is not asked: its versions are others: msgspec" in said[0]


@pytest.mark.parametrize("text", ["local:x", "localhost:8786", "tcp://host", "tcp://:8786x", ""])
def test_what_is_no_address(text: str) -> None:
    with pytest.raises(ClusterError, match="expected local, local:WORKERS or a scheduler"):
        Address.parse(text)


def test_addresses() -> None:
    assert Address.parse("tcp://10.0.0.1:8786") == Address("tcp://10.0.0.1:8786")
    assert Address.parse("local:3") == Address(workers=3)
    assert Address.parse("local").workers >= 1


def test_processes_have_the_hash_seed_of_the_session_and_not_of_the_worker(cluster: Cluster, echo: Path) -> None:
    for seed in ("7", "8"):
        asked = replace(service(echo), hash_seed=seed)
        (answer,) = ask(cluster, asked, '["hash seed"]').values()
        assert lines(answer) == [f'"{seed}!"']
