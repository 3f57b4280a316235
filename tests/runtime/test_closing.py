"""Closing a run ends, whatever its nodes do in their `finally` clauses; the place is said."""

from __future__ import annotations

import contextlib
from collections.abc import Callable

import pytest

from pytest_hricdv.runtime import Kernel
from pytest_hricdv.runtime.node_error import KernelError


def _sleeping(kernel: Kernel, afterwards: Callable[[], None]) -> Callable[[], None]:
    def body() -> None:
        try:
            kernel.sleep(100.0)
        finally:
            afterwards()

    return body


def _forever() -> None:
    while True:
        pass


def _whatever_comes() -> None:
    while True:
        with contextlib.suppress(BaseException):
            _forever()


@pytest.mark.parametrize("afterwards", [_forever, _whatever_comes], ids=["loops", "catches everything"])
def test_a_node_that_loops_while_the_run_closes_is_ended_with_its_place(afterwards: Callable[[], None]) -> None:
    kernel = Kernel(stuck_after_s=0.2)
    ended: list[str] = []
    kernel.spawn("first", _sleeping(kernel, lambda: ended.append("first")))
    kernel.spawn("robot", _sleeping(kernel, afterwards))
    kernel.spawn("last", _sleeping(kernel, lambda: ended.append("last")))
    kernel.run(1.0)
    with pytest.raises(KernelError, match=r"no time has passed for 0\.2 s of work, at .*test_closing\.py:\d+"):
        kernel.close()
    assert ended == ["first", "last"]
    assert all(node.ended for node in kernel.nodes)
