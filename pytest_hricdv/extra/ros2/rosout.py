"""The topic `/rosout`: what the logger of a node, and those below it, log."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pytest_hricdv.extra.ros2.clocks import system_ns
from pytest_hricdv.extra.ros2.contexts import Node
from pytest_hricdv.extra.ros2.logging import LogEntry, log_of
from pytest_hricdv.extra.ros2.qos import TRANSIENT_LOCAL, Profile
from pytest_hricdv.extra.ros2.topics import Publisher

_NS_PER_S = 1_000_000_000

PROFILE = Profile(depth=1000, durability=TRANSIENT_LOCAL, lifespan_ns=10 * _NS_PER_S)
"""As rcl publishes it."""


class LoggedNode(Node):
    """A node whose log is published, unless `enable_rosout` or the arguments of its context say otherwise."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._publisher: Publisher | None = None
        if self.enable_rosout and self.context.arguments.rosout:
            from rcl_interfaces.msg import Log  # type: ignore[import-not-found, unused-ignore]

            self._kind = Log
            self._publisher = Publisher(self, Log, "/rosout", PROFILE)
            log_of(self.kernel).listeners.setdefault(self.logger_name(), []).append(self._publish)

    def _publish(self, entry: LogEntry) -> None:
        assert self._publisher is not None
        message = self._kind(level=int(entry.severity), name=entry.logger, msg=entry.text)
        message.function, message.file, message.line = entry.function, Path(entry.file).name, entry.line
        message.stamp.sec, message.stamp.nanosec = divmod(system_ns(self.kernel), _NS_PER_S)
        self._publisher.publish(message)

    def destroy(self) -> None:
        """Leave the graph; nothing of its log is published any more."""
        if self._publisher is not None:
            self._publisher.destroy_when_not_in_use()
            listeners = log_of(self.kernel).listeners
            for name, callbacks in listeners.items():
                listeners[name] = [callback for callback in callbacks if callback != self._publish]
        super().destroy()
