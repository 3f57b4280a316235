"""What a context, or a process, has in the graph ends with it."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from pytest_hricdv.extra.ros2 import contexts
from pytest_hricdv.extra.ros2.processes import ModuleVariables, Process
from pytest_hricdv.extra.ros2.qos import Profile
from pytest_hricdv.extra.ros2.services import Client, ServiceServer
from pytest_hricdv.extra.ros2.topics import Publisher, TopicSubscription
from pytest_hricdv.runtime import Kernel
from pytest_hricdv.runtime.virtual import VirtualModules
from pytest_hricdv.runtime.virtual.outside import guard_run
from tests.extra.ros2.system import Grasp, Reading, node

Entities = dict[str, Any]


def _entities(made: contexts.GraphNode) -> Entities:
    return {
        "service": ServiceServer(made, Grasp, "/grasp", Profile()),
        "client": Client(made, Grasp, "/other", Profile()),
        "publisher": Publisher(made, Reading, "/scan", Profile()),
        "subscription": TopicSubscription(made, Reading, "/goal", Profile()),
    }


def _visible(observer: contexts.GraphNode) -> list[int]:
    return [
        observer.get_count_services("/grasp"),
        observer.get_count_clients("/other"),
        observer.get_count_publishers("/scan"),
        observer.get_count_subscribers("/goal"),
        len(observer.get_node_names_and_namespaces()),
    ]


@pytest.fixture
def virtual() -> Iterator[None]:
    """`threading` of this module in virtual time."""
    with VirtualModules([__name__]).install():
        yield


def _observed(main: Callable[[Kernel], None], at_s: float) -> list[int]:
    """What is left in the graph of a process with this main function, at a time (s)."""
    kernel = Kernel()
    kernel.virtual = frozenset({"time", "threading"})
    seen: list[list[int]] = []

    def observe() -> None:
        observer = node("observer")
        kernel.sleep(at_s)
        seen.append(_visible(observer))

    kernel.spawn("arm", Process(kernel, ModuleVariables([]), ["arm"]).wrap(lambda: main(kernel)))
    kernel.spawn("observer", observe)
    try:
        with guard_run(kernel):
            kernel.run(10.0)
    finally:
        kernel.close()
    return seen[0]


def _works(kernel: Kernel) -> None:
    _entities(node("arm"))
    kernel.sleep(1.0)


def test_what_a_process_has_ends_with_it_without_a_shutdown() -> None:
    assert _observed(_works, 0.5) == [1, 1, 1, 1, 2]
    assert _observed(_works, 1.5) == [0, 0, 0, 0, 1]


@pytest.mark.usefixtures("virtual")
@pytest.mark.parametrize(("daemon", "left"), [(True, [0, 0, 0, 0, 1]), (False, [1, 1, 1, 1, 2])])
def test_a_process_waits_for_its_threads_except_daemons(daemon: bool, left: list[int]) -> None:
    """A daemon ends where it is: its `finally` clauses are not run."""
    ended = []

    def main(kernel: Kernel) -> None:
        def thread() -> None:
            try:
                kernel.sleep(2.0)
            finally:
                ended.append(kernel.now_s)

        threading.Thread(target=thread, daemon=daemon).start()
        _works(kernel)

    assert _observed(main, 1.5) == left
    assert ended == ([] if daemon else [2.0])
