"""Clients of the simulated world: what blocks here blocks a node of the kernel, in simulated time."""

from __future__ import annotations

from typing import Any

from pytest_hricdv.extra.ros2.clocks import whole_ns
from pytest_hricdv.extra.ros2.handles import Awaited
from pytest_hricdv.extra.ros2.services import Client
from pytest_hricdv.extra.ros2.wait_set import WaitSet

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

_LOOKS_EVERY_S = 0.01
"""How often a client looks whether there is a server. Chosen: servers appear in the first milliseconds, if they do."""


class ServiceClient:
    """A client of a service."""

    def __init__(self, client: Client) -> None:
        self._client = client

    def call(self, timeout_s: float, **fields: Any) -> Any | None:
        """Ask with a request that has these fields; the response, or None if there is none within `timeout_s`."""
        return answer(self._client, self._client.kind.Request(**fields), timeout_s)


def answer(client: Client, request: Any, timeout_s: float) -> Any | None:
    """The response to a request, which waits for a server; responses to earlier ones, too late, are dropped."""
    kernel = client.kernel
    end_s = kernel.now_s + timeout_s
    # The graph wakes nobody when a server comes, as in `rclpy`, which looks every 0.25 s.
    while not client.service_server_is_available():
        if kernel.now_s + _LOOKS_EVERY_S > end_s:
            return None
        kernel.sleep(_LOOKS_EVERY_S)
    number = client.send_request(request)
    while True:
        wait_for("client", client, max(end_s - kernel.now_s, 0.0))
        info, response = client.take_response(client.kind.Response)
        if info is None:
            return None
        if info.request_id.sequence_number == number:
            return response


def wait_for(kind: str, entity: Awaited, timeout_s: float | None) -> None:
    """Wait until a subscription, service or client has something, at most `timeout_s`; None: as long as it takes."""
    waiting = WaitSet()
    getattr(waiting, f"add_{kind}")(entity)
    waiting.wait(-1 if timeout_s is None else whole_ns(timeout_s))
