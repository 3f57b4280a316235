"""Questions to workers of this machine: real ones of Dask, and a service that is a few lines long."""

from __future__ import annotations

import os
import socket
import ssl
import stat
import subprocess
import sys
from collections import deque
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import dask
import psutil
import pytest
from distributed import Worker
from distributed.security import Security

from benchmarks import lost_workers
from pytest_hricdv.extra.cluster import code_archive
from pytest_hricdv.extra.cluster import service as worker_side
from pytest_hricdv.extra.cluster.cluster import Cluster, connect
from pytest_hricdv.extra.cluster.connection import Address
from pytest_hricdv.session.remote import Answer, ClusterError, LostRequest, Service, WorkRequest
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


def unheard(text: str) -> None:
    """Ignore what is reported of the workers."""


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
    with connect(Address(workers=2), said.append) as made:
        yield made


def service(echo: Path, *, has: str = "0123456789abcdef", silent_s: float = 20.0) -> Service:
    """The service; its processes say that they have this project."""
    job = f'{{"project": {{"robot.py": "{has}"}}}}'.encode()
    return Service("echo_service", job, str(echo), PROJECT, silent_s)


def ask(cluster: Cluster, asked: Service, *questions: str) -> dict[str, Answer | LostRequest]:
    """Key -> answer to questions, each a JSON list of words."""
    queue = deque(WorkRequest(text, text.encode()) for text in questions)
    return {question.key: answer for question, answer in cluster.answers(asked, queue)}


def lines(answer: Answer | LostRequest) -> list[str]:
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


def listening() -> dict[int, tuple[str, str]]:
    """Port -> address and process, of all sockets that take connections in this process and in its children."""
    own = psutil.Process()
    return {
        port.laddr.port: (port.laddr.ip, process.name())
        for process in (own, *own.children(recursive=True))
        for port in process.net_connections("all")
        if port.status == psutil.CONN_LISTEN
    }


def test_workers_of_this_machine_listen_on_loopback_only_and_answer_nothing_without_credentials(
    cluster: Cluster,
) -> None:
    """Neither a browser nor a client in the clear, nor TLS without a certificate or with one of somebody else."""
    ports = listening()
    assert len(ports) >= 2 + 2 * 3, "scheduler, its HTTP server; two nannies, workers, and HTTP servers of these"
    assert {address for address, _ in ports.values()} == {"127.0.0.1"}
    assert cluster.connection.dashboard == ""
    encrypted = 0
    for port in ports:
        answer = spoken(port, b"GET / HTTP/1.0\r\n\r\n")
        assert answer in (b"", b"HTTP/1.1 404 Not Found")
        encrypted += not answer
        for client in () if answer else (anonymous(), stranger()):
            with pytest.raises(OSError, match=r"CERTIFICATE|ALERT|HTTP_REQUEST|WRONG_VERSION|EOF|reset|closed"):
                refused(port, client)
    assert encrypted >= 1 + 2 * 2


def spoken(port: int, text: bytes) -> bytes:
    """The first line that is answered to a text in the clear."""
    with socket.create_connection(("127.0.0.1", port), timeout=20) as connection, suppress(ConnectionResetError):
        connection.sendall(text)
        return connection.makefile("rb").readline().strip()
    return b""


def anonymous() -> ssl.SSLContext:
    """Of a client that believes every server, and has no certificate."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    return context


def stranger() -> ssl.SSLContext:
    """Of a client that believes every server, and has a certificate of its own making."""
    context = Security.temporary().get_connection_args("client")["ssl_context"]
    assert isinstance(context, ssl.SSLContext)
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    return context


def refused(port: int, client: ssl.SSLContext) -> None:
    """Raises what a TLS client is told; the last version tells it after the client's side of the handshake."""
    with (
        socket.create_connection(("127.0.0.1", port), timeout=20) as connection,
        client.wrap_socket(connection) as encrypted,
    ):
        encrypted.sendall(b"anybody there?")
        assert encrypted.recv(1) == b"", "nothing is said"
        raise ConnectionError("closed")


INTRUDER = """
import sys
from distributed import Client
from distributed.security import Security

for scheme, security in (("tcp", None), ("tls", Security.temporary())):
    try:
        client = Client(f"{scheme}://127.0.0.1:{sys.argv[1]}", security=security, timeout=3)
    except (OSError, TimeoutError) as error:
        print(scheme, "refused", flush=True)
    else:
        print(scheme, client.submit(lambda: "ran").result(timeout=5), flush=True)
"""


@pytest.mark.slow
def test_another_process_runs_no_code_in_workers_of_this_machine(cluster: Cluster) -> None:
    port = cluster.connection.client.scheduler_info()["address"].rpartition(":")[2]
    client = [sys.executable, "-c", INTRUDER, port]
    done = subprocess.run(client, capture_output=True, text=True, timeout=120, check=False, env=environment())
    assert done.stdout == "tcp refused\ntls refused\n", done.stderr


def test_credentials_are_in_memory_only(cluster: Cluster) -> None:
    """Not in an environment, a command line or a file: other processes, and reports of failures, may show these."""
    own = psutil.Process()
    (folder,) = {str(Path(path).parent) for path in cluster.connection.client.run(scratch).values()}
    for process in own.children(recursive=True):
        assert "BEGIN" not in str(process.cmdline()) + str(process.environ())
    for path in Path(folder).rglob("*"):
        assert path.is_dir() or b"BEGIN" not in path.read_bytes()
    assert stat.S_IMODE(Path(folder).parent.stat().st_mode) == 0o700, "and these folders are for this user only"


def scratch(dask_worker: Worker) -> str:
    """The folder of a worker, in which Python looks for modules first."""
    return str(dask_worker.local_directory)


def test_python_looks_for_modules_in_no_folder_of_a_cluster_that_has_ended(echo: Path) -> None:
    before = [*sys.path]
    with connect(Address(workers=1), unheard):
        pass
    assert sys.path == before


def test_a_folder_for_temporary_files_that_anybody_may_change_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "open").mkdir()
    (tmp_path / "open").chmod(0o777)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "open"))
    with pytest.raises(ClusterError, match=r"local:1: .*open: others may write to it \(mode 0777, not sticky\)"):
        connect(Address(workers=1), unheard).__enter__()


def test_a_cluster_of_others_without_tls_is_warned_about(echo: Path) -> None:
    said: list[str] = []
    with pytest.raises(ClusterError, match="no scheduler answers there"):
        connect(Address(f"tcp://127.0.0.1:{lost_workers.free_port()}"), said.append).__enter__()
    assert len(said) == 1
    assert "is neither encrypted nor authenticated: whoever reaches its port can run code" in said[0]


@pytest.mark.parametrize("files", [(), ("ca", "cert", "key")])
def test_tls_without_credentials_says_which_are_expected(tmp_path: Path, files: tuple[str, ...]) -> None:
    """None; and files that have none in them."""
    for name in files:
        (tmp_path / name).write_text("no PEM", encoding="ascii")
    settings = {"ca-file": "ca", "client.cert": "cert", "client.key": "key"}
    with (
        dask.config.set(
            {f"distributed.comm.tls.{name}": str(tmp_path / file) for name, file in settings.items() if file in files}
        ),
        pytest.raises(ClusterError, match=r"Dask's settings.*: expected PEM files of the CA, .*TLS__CA_FILE"),
    ):
        connect(Address("tls://127.0.0.1:9"), unheard).__enter__()


def test_a_project_that_is_another_one_is_refused_before_it_is_imported(
    cluster: Cluster, echo: Path, tmp_path: Path
) -> None:
    """Where it is at the same path, and where it was sent; the module of the service would say that it was imported."""
    (tmp_path / "conftest.py").write_text("# another user's\n", encoding="utf-8")
    archive = code_archive.pack(tmp_path, code_archive.files_to_send(tmp_path))
    evil = f"import pathlib; pathlib.Path({str(tmp_path / 'ran')!r}).touch()"
    (echo / "evil_service.py").write_text(evil, encoding="utf-8")
    own = {"conftest.py": "0123456789abcdef"}
    there = Service("evil_service", b"{}", str(tmp_path), {}, 20.0, sources=own)
    sent = replace(there, directory=".", archive=archive, archive_sha256="0" * 64)
    for asked in (there, sent):
        answer = cluster.connection.client.submit(worker_side.ask, asked, b"[]", pure=False).result()
        assert "conftest.py changed" in answer.unable
    assert not (tmp_path / "ran").exists()


@pytest.mark.slow
def test_a_process_that_is_silent_for_too_long_is_ended(cluster: Cluster, echo: Path) -> None:
    (answer,) = ask(cluster, service(echo, silent_s=2.0), '["hang"]').values()
    assert isinstance(answer, Answer)
    assert answer.problem == "no sign of life for 2 s"


def test_a_worker_with_another_project_is_refused_and_named(echo: Path) -> None:
    said: list[str] = []
    refused = pytest.raises(ClusterError, match=r"no worker can be used: tls://.*robot\.py changed")
    with connect(Address(workers=1), said.append) as made, refused:
        ask(made, service(echo, has="fedcba9876543210"), '["one"]')
    assert len(said) == 1
    assert said[0].startswith("worker tls://127.0.0.1:")
    assert f"its project in {echo} is another one: robot.py changed" in said[0]


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

    with connect(Address(workers=2), unheard) as made:
        queue = deque(WorkRequest(str(number), f'["{number}"]'.encode()) for number in range(30))
        found = [(question.key, lines(answer)) for question, answer in made.answers(service(echo), queue, kill_one)]
    assert sorted(found) == sorted((str(number), [f'"{number}!"']) for number in range(30))
    assert len(told) == 3


@pytest.mark.slow
def test_workers_of_this_machine_that_do_not_come_back_are_started_anew(
    echo: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pytest_hricdv.extra.cluster.cluster.WAIT_FOR_LOCAL_S", 0.5)
    said: list[str] = []
    with connect(Address(workers=1), said.append) as made:
        local = made.connection._local
        assert local is not None
        local.cluster.scale(0)
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
            with pytest.raises(ClusterError, match=r"no worker can be used: .*msgspec .*, now 0\.0\.1"):
                connect(Address(scheduler.address), said.append).__enter__()
            process.kill()
    assert len(said) == 2
    assert "is neither encrypted nor authenticated" in said[0]
    assert "is not used: its versions differ: msgspec" in said[1]


@pytest.mark.parametrize("text", ["local:x", "localhost:8786", "tcp://host", "tcp://:8786x", ""])
def test_what_is_no_address(text: str) -> None:
    with pytest.raises(ClusterError, match="expected local, local:WORKERS or a scheduler"):
        Address.parse(text)


def test_processes_have_the_hash_seed_of_the_session_and_not_of_the_worker(cluster: Cluster, echo: Path) -> None:
    (answer,) = ask(cluster, replace(service(echo), hash_seed="8"), '["hash seed"]').values()
    assert lines(answer) == ['"8!"']
