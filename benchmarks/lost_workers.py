"""A campaign whose workers, client and scheduler are killed, against one that nobody disturbs.

    python -m benchmarks.lost_workers [--suite NAME] [--tests N] [--concretizations K] [--workers 20] [--clients 3]

Both campaigns have a scheduler and two workers of Dask of their own. In the disturbed one, workers are killed at random
moments (SIGKILL; their nannies start others), the client several times, whereupon the same command is given again, and
the scheduler once, whereupon it and its workers are started again. The reports of both have to be the same bytes, times
aside. Ends with 1 where they are not.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

import psutil

QUIET = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
TIMES = ("wall_s", "workers")


@dataclass
class Cluster:
    """A scheduler and workers of Dask, as a supervisor keeps them: what ends is started again."""

    workers: int
    port: int = field(default_factory=lambda: free_port())
    _scheduler: subprocess.Popen[bytes] | None = None
    _nannies: list[subprocess.Popen[bytes]] = field(default_factory=list)

    @property
    def address(self) -> str:
        """Of the scheduler."""
        return f"tcp://127.0.0.1:{self.port}"

    def keep(self) -> None:
        """Start what is not there."""
        if self._scheduler is None or self._scheduler.poll() is not None:
            options = ["--host=127.0.0.1", f"--port={self.port}", "--no-dashboard", "--no-jupyter", "--no-show"]
            self._scheduler = self._started("distributed.cli.dask_scheduler", options)
            self._await_scheduler()
        self._nannies = [nanny for nanny in self._nannies if nanny.poll() is None]
        while len(self._nannies) < self.workers:
            options = [self.address, "--nthreads=1", "--memory-limit=0", "--no-dashboard", "--death-timeout=20"]
            self._nannies.append(self._started("distributed.cli.dask_worker", options))

    def _await_scheduler(self) -> None:
        """Until it listens: clients and workers that find nobody give up at some time."""
        while self._scheduler is not None and self._scheduler.poll() is None:
            with suppress(OSError), socket.create_connection(("127.0.0.1", self.port), timeout=1):
                return
            time.sleep(0.05)  # it only asks again: what it waits for is the open port

    def _started(self, module: str, options: list[str]) -> subprocess.Popen[bytes]:
        return subprocess.Popen([sys.executable, "-m", module, *options], cwd=tempfile.gettempdir(), **QUIET)  # type: ignore[call-overload,no-any-return]

    def kill_worker(self, rng: random.Random) -> bool:
        """Kill a worker, if one is there; its nanny starts another one."""
        alive = [child for nanny in self._nannies for child in children(nanny.pid) if is_worker(child)]
        if not alive:
            return False
        with suppress(psutil.NoSuchProcess):
            rng.choice(alive).kill()
        return True

    def kill_scheduler(self) -> None:
        """Kill the scheduler."""
        if self._scheduler is not None:
            self._scheduler.kill()
            self._scheduler.wait()

    def end(self) -> None:
        """End everything."""
        for process in [*self._nannies, *([self._scheduler] if self._scheduler else [])]:
            for child in [*children(process.pid)]:
                with suppress(psutil.NoSuchProcess):
                    child.kill()
            process.kill()
            process.wait()


def free_port() -> int:
    """A port that nobody listens to."""
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return int(listener.getsockname()[1])


def children(pid: int) -> list[psutil.Process]:
    """The processes that a process has started."""
    with suppress(psutil.NoSuchProcess):
        return list(psutil.Process(pid).children())
    return []


def is_worker(process: psutil.Process) -> bool:
    """Whether a nanny's child is its worker; the other one tracks resources."""
    with suppress(psutil.NoSuchProcess, psutil.ZombieProcess):
        return "resource_tracker" not in " ".join(process.cmdline())
    return False


@contextmanager
def cluster(workers: int) -> Iterator[Cluster]:
    """A cluster, ended in the end."""
    made = Cluster(workers)
    try:
        made.keep()
        yield made
    finally:
        made.end()


def start(options: argparse.Namespace, address: str, state: Path) -> subprocess.Popen[str]:
    """The client of a campaign."""
    size = [f"--suite={options.suite}", f"--concretizations={options.concretizations}", f"--cluster={address}"]
    size += [f"--tests={options.tests}"] if options.tests else []
    arguments = [sys.executable, "-m", "pytest_hricdv.campaign", "run", *size, f"--state={state}"]
    return subprocess.Popen(
        arguments, cwd=options.root, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, encoding="utf-8"
    )


def undisturbed(options: argparse.Namespace, state: Path) -> str:
    """What a campaign says that nobody disturbs."""
    with cluster(2) as made, start(options, made.address, state) as client:
        return client.communicate()[0]


def disturbed(options: argparse.Namespace, state: Path) -> str:
    """What a campaign says in the end whose workers, client and scheduler are killed."""
    rng = random.Random(options.seed)
    fates = ["worker"] * options.workers + ["client"] * options.clients + ["scheduler"]
    rng.shuffle(fates)
    with cluster(2) as made:
        client = start(options, made.address, state)
        said = ""
        while True:
            with suppress(subprocess.TimeoutExpired):
                said = client.communicate(timeout=rng.uniform(0.5, 2.0) * options.pace)[0]
                if client.returncode in (0, 1, 2):  # all was done, or cannot be done
                    break
                client = start(options, made.address, state)
            made.keep()
            if fates:
                happens(fates, made, client, rng)
        if fates:
            said += f"ended before all was killed: {fates}\n"
        return said


def happens(fates: list[str], made: Cluster, client: subprocess.Popen[str], rng: random.Random) -> None:
    """The next thing is killed, if it is there."""
    if fates[-1] == "worker":
        if not made.kill_worker(rng):
            return
    elif fates[-1] == "client":
        os.kill(client.pid, signal.SIGKILL)
    else:
        made.kill_scheduler()
    print(f"killed: {fates.pop()}", flush=True)


def timeless(value: object) -> object:
    """A report without times."""
    if isinstance(value, dict):
        return {name: timeless(part) for name, part in value.items() if name not in TIMES}
    return [timeless(part) for part in value] if isinstance(value, list) else value


def reported(options: argparse.Namespace, state: Path) -> str:
    """The report of a campaign, times aside."""
    folder = state.with_suffix("")
    arguments = [sys.executable, "-m", "pytest_hricdv.campaign", "report", f"--state={state}", f"--output={folder}"]
    subprocess.run(arguments, cwd=options.root, stdout=subprocess.DEVNULL, check=False)
    text = (folder / "report.json").read_text(encoding="utf-8").replace(str(folder), "FOLDER")
    return json.dumps(timeless(json.loads(text.replace(os.path.relpath(folder, options.root), "FOLDER"))))


def size_options(parser: argparse.ArgumentParser) -> None:
    """What is run, and where."""
    parser.add_argument("--suite", default="rl")
    parser.add_argument("--tests", type=int, default=100, help="abstract tests (default 100)")
    parser.add_argument("--concretizations", type=int, default=4, help="seeds of each (default 4)")
    parser.add_argument("--root", type=Path, default=Path.cwd(), help="the project")
    parser.add_argument("--state", type=Path, help="folder of the campaigns (default: a temporary one)")


def main() -> None:
    """Run both campaigns, and compare their reports."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    size_options(parser)
    parser.add_argument("--workers", type=int, default=20, help="times that a worker is killed (default 20)")
    parser.add_argument("--clients", type=int, default=3, help="times that the client is killed (default 3)")
    parser.add_argument("--pace", type=float, default=5.0, help="mean time between two, about (s, default 5)")
    parser.add_argument("--seed", type=int, default=0, help="of what is killed when (default 0)")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        where = (options.state or Path(folder)).resolve()
        where.mkdir(parents=True, exist_ok=True)
        print(disturbed(options, where / "disturbed.db"))
        print(undisturbed(options, where / "undisturbed.db"))
        same = reported(options, where / "disturbed.db") == reported(options, where / "undisturbed.db")
    print("the reports are the same, times aside" if same else "the reports differ")
    sys.exit(0 if same else 1)


if __name__ == "__main__":
    main()
