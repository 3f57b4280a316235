"""Simulates the loggers of `rclpy`: each run has a `RosLog` with the levels of loggers, and log entries.

`extension` gives the functions of this module to `rclpy`. `log_of` returns the log of a run, from which a node of
`extension` publishes its entries on `/rosout`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import IntEnum

from pytest_hricdv.extra.ros2.contexts import Context
from pytest_hricdv.extra.ros2.handles import current_kernel, node_that_runs
from pytest_hricdv.extra.ros2.processes import process_of
from pytest_hricdv.runtime.kernel import Kernel

SEPARATOR = "."  # between the name of a logger and the names of those below it


class Severity(IntEnum):
    """The levels of log entries, like `RCUTILS_LOG_SEVERITY`."""

    RCUTILS_LOG_SEVERITY_UNSET = 0
    RCUTILS_LOG_SEVERITY_DEBUG = 10
    RCUTILS_LOG_SEVERITY_INFO = 20
    RCUTILS_LOG_SEVERITY_WARN = 30
    RCUTILS_LOG_SEVERITY_ERROR = 40
    RCUTILS_LOG_SEVERITY_FATAL = 50

    @property
    def text(self) -> str:
        """The name that a log shows."""
        return self.name.rpartition("_")[2]


@dataclass(frozen=True)
class LogEntry:
    """A log entry: its text, its time (s, simulated), its logger, and the location of the call."""

    time_s: float
    severity: Severity
    logger: str
    text: str
    function: str
    file: str
    line: int


@dataclass
class RosLog:
    """The log of a run, and the levels of its loggers; each process has its own levels."""

    levels: dict[object, dict[str, int]] = field(default_factory=dict)
    """Process -> name of a logger -> its level; "" is the one that all others inherit from."""
    entries: list[LogEntry] = field(default_factory=list)
    listeners: dict[str, list[Callable[[LogEntry], None]]] = field(default_factory=dict)
    """Name of a logger -> its listeners, as often as they were added; only the last one is called."""

    def level(self, name: str, process: object) -> int:
        """The level of a logger: its own, or that of the nearest one above it that has one."""
        levels = self.levels.get(process, {})
        while name:
            if levels.get(name):
                return levels[name]
            name = name.rpartition(SEPARATOR)[0]
        return levels.get("", int(Severity.RCUTILS_LOG_SEVERITY_INFO))


def log_of(kernel: Kernel) -> RosLog:
    """The log of a run."""
    log = kernel.own.setdefault("ros2 log", RosLog())
    assert isinstance(log, RosLog)
    return log


def _levels() -> dict[str, int]:
    """The levels of the running process."""
    kernel = current_kernel("a logger of rclpy")
    return log_of(kernel).levels.setdefault(process_of(kernel.current()), {})


def reset_levels() -> None:
    """Forget all levels that this process has set; outside of a run there are none."""
    node = node_that_runs()
    if node is not None:
        log_of(node.kernel).levels.pop(process_of(node), None)


def configure(context: Context) -> None:
    """Set the levels given in the arguments of a context."""
    for name, level in context.arguments.log_levels:
        set_logger_level(name, level_from_string(level))


def set_logger_level(name: str, level: int, detailed_error: bool = False) -> None:
    """Set the level of a logger; UNSET: that of its parent. Raises RuntimeError for an invalid level."""
    if level not in tuple(Severity):
        raise RuntimeError(f"Failed to set level for logger: {level} is not a level")
    _levels()[name] = int(level)


def logger_level(name: str) -> int:
    """The level that was set; UNSET if none was."""
    return _levels().get(name, Severity.RCUTILS_LOG_SEVERITY_UNSET)


def effective_level(name: str) -> int:
    """The level that counts."""
    kernel = current_kernel("a logger of rclpy")
    return log_of(kernel).level(name, process_of(kernel.current()))


def is_enabled_for(name: str, severity: int) -> bool:
    """Whether what is logged with this severity is kept."""
    return severity >= effective_level(name)


def level_from_string(name: str) -> int:
    """The level of a name in any case. Raises RuntimeError for a name that is none."""
    level = next((severity for severity in Severity if severity.text == name.upper()), None)
    if level is None:
        raise RuntimeError(f"Failed to get log severity from name: '{name}'")
    return level


def add_sublogger(name: str, sublogger: str) -> bool:
    """Publish what a logger below another one logs where that one's is; False if that one's is not published."""
    node = node_that_runs()
    listeners = {} if node is None else log_of(node.kernel).listeners
    if not listeners.get(name):
        return False
    listeners.setdefault(f"{name}{SEPARATOR}{sublogger}", []).append(listeners[name][-1])
    return True


def remove_sublogger(name: str, sublogger: str) -> None:
    """Undo one `add_sublogger`; also while Python cleans up, when no node runs and nothing is left to undo."""
    node = node_that_runs()
    listeners = {} if node is None else log_of(node.kernel).listeners
    if listeners.get(full := f"{name}{SEPARATOR}{sublogger}"):
        listeners[full].pop()


def write(severity: int, name: str, message: object, function: str, file: str, line: int) -> None:
    """Log a message. What is logged outside of a run, as while a module is imported, is not kept.

    Raises:
        TypeError: the message is not text: `rclpy` takes str, bytes and None only, for C's `const char *`.
    """
    if message is None:
        message = "(null)"
    elif isinstance(message, bytes):
        message = message.decode(errors="replace")
    elif not isinstance(message, str):
        raise TypeError(f"rclpy_logging_rcutils_log(): a message of a log is a str, not {type(message).__name__}")
    node = node_that_runs()
    if node is None:
        return
    log = log_of(node.kernel)
    if severity >= log.level(name, process_of(node)):
        entry = LogEntry(node.kernel.now_s, Severity(severity), name, message, function, file, line)
        log.entries.append(entry)
        for listener in log.listeners.get(name, ())[-1:]:
            listener(entry)
