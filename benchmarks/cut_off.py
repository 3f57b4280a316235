"""A campaign on three hosts, one of which is cut off in mid-run and comes back, against one that nobody disturbs.

    python -m benchmarks.cut_off [--suite NAME] [--tests N] [--concretizations K] [--after S] [--for S]

The hosts are network namespaces of Linux with addresses of their own on a bridge (it takes root, and ip of iproute2),
with a worker of Dask each; scheduler and client are outside of them. Each run has to be stored once, and the reports of
both campaigns have to be the same bytes, times aside. Ends with 1 where they are not.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from benchmarks.lost_workers import QUIET, reported, size_options, start, undisturbed
from pytest_hricdv.extra.campaign.store import Store

BRIDGE, NETWORK, PORT = "hricdv0", "10.213.7", 8786
HOSTS = ("hricdv-1", "hricdv-2", "hricdv-3")


def ip(*arguments: str) -> None:
    """A command of iproute2. Raises subprocess.CalledProcessError."""
    subprocess.run(["ip", *arguments], check=True)


@contextmanager
def hosts() -> Iterator[None]:
    """The namespaces, each with a cable to the bridge; gone in the end."""
    with ExitStack() as stack:
        ip("link", "add", BRIDGE, "type", "bridge")
        stack.callback(ip, "link", "del", BRIDGE)
        ip("addr", "add", f"{NETWORK}.1/24", "dev", BRIDGE)
        ip("link", "set", BRIDGE, "up")
        for number, name in enumerate(HOSTS):
            cable = f"{name}-c"
            ip("netns", "add", name)
            stack.callback(ip, "netns", "del", name)
            ip("link", "add", cable, "type", "veth", "peer", "name", "eth0", "netns", name)
            ip("link", "set", cable, "master", BRIDGE, "up")
            ip("-n", name, "addr", "add", f"{NETWORK}.{11 + number}/24", "dev", "eth0")
            ip("-n", name, "link", "set", "eth0", "up")
            ip("-n", name, "link", "set", "lo", "up")
        yield


@contextmanager
def workers() -> Iterator[str]:
    """The address of a scheduler with a worker on each host; one that ends is started again, as by a supervisor."""
    address = f"tcp://{NETWORK}.1:{PORT}"
    scheduler = [sys.executable, "-m", "distributed.cli.dask_scheduler", f"--host={NETWORK}.1", f"--port={PORT}"]
    with ExitStack() as stack:
        stack.enter_context(ended(subprocess.Popen([*scheduler, "--no-dashboard"], cwd=tempfile.gettempdir(), **QUIET)))  # type: ignore[call-overload]
        for number, name in enumerate(HOSTS):
            worker = [sys.executable, "-m", "distributed.cli.dask_worker", address, f"--host={NETWORK}.{11 + number}"]
            again = f"while true; do {' '.join(worker)} --nthreads=1 --memory-limit=0 --no-dashboard; sleep 1; done"
            command = ["ip", "netns", "exec", name, "sh", "-c", again]
            process = subprocess.Popen(command, cwd=tempfile.gettempdir(), start_new_session=True, **QUIET)  # type: ignore[call-overload]
            stack.enter_context(ended(process))
            stack.callback(subprocess.run, f"ip netns pids {name} | xargs -r kill -9", shell=True, check=False)
        yield address


@contextmanager
def ended(process: subprocess.Popen[bytes]) -> Iterator[None]:
    """A process, ended in the end."""
    try:
        yield
    finally:
        process.kill()
        process.wait()


def cut_off(options: argparse.Namespace, state: Path) -> str:
    """What a campaign says one of whose hosts is cut off for a while."""
    with hosts(), workers() as address:
        began_s = time.monotonic()
        with start(options, address, state) as client:
            for at_s, turned in ((options.after, "down"), (options.after + options.silent, "up")):
                time.sleep(max(0.0, began_s + at_s - time.monotonic()))  # how long it is cut off is what is tried
                ip("link", "set", f"{HOSTS[0]}-c", turned)
                print(
                    f"{HOSTS[0]} is {turned}; the client {'runs' if client.poll() is None else 'has ended'}",
                    flush=True,
                )
            return client.communicate()[0]


def main() -> None:
    """Run both campaigns, and compare their reports."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    size_options(parser)
    parser.add_argument("--after", type=float, default=25.0, help="when the host is cut off (s, default 25)")
    parser.add_argument("--for", dest="silent", type=float, default=45.0, help="for how long (s, default 45)")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        where = (options.state or Path(folder)).resolve()
        where.mkdir(parents=True, exist_ok=True)
        print(cut_off(options, where / "cut-off.db"))
        store = Store.open(where / "cut-off.db")
        by_host = {store.workers()[number].address: runs for number, runs in store.runs_of_workers().items()}
        print(f"runs by worker: {by_host}")
        print(f"expected {store.plan().runs}, stored {store.counts().runs}, each once: it is the key of its row")
        print(undisturbed(options, where / "undisturbed.db"))
        same = reported(options, where / "cut-off.db") == reported(options, where / "undisturbed.db")
    print("the reports are the same, times aside" if same else "the reports differ")
    sys.exit(0 if same else 1)


if __name__ == "__main__":
    main()
