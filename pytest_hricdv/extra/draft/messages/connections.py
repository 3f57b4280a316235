"""Connections that the code makes itself: serial lines, sockets, clients of a broker; what it reads and writes."""

from __future__ import annotations

import ast

from pytest_hricdv.extra.draft.reading.sources import Module, imported_name

MODULES = ("serial", "socket", "zmq", "websocket", "websockets", "paho", "can", "bluetooth", "pynng", "nats", "pika",
           "redis", "aioserial", "serial_asyncio", "stomp", "roslibpy", "rospy")  # fmt: skip
"""Top-level modules whose classes are connections."""

RECEIVES = ("recv", "recvfrom", "recv_json", "recv_string", "recv_pyobj", "receive", "receive_json", "receive_text",
            "receive_bytes", "readline", "read_until", "read", "read_all", "readuntil", "recv_multipart")  # fmt: skip
SENDS = ("send", "sendall", "sendto", "send_json", "send_string", "send_pyobj", "send_text", "send_bytes", "write",
         "publish")  # fmt: skip
LINES = ("readline", "read_until", "readuntil")
"""Names of calls that return a line, with its end."""


def constructor(node: ast.AST, module: Module) -> tuple[str, str] | None:
    """Name and attribute under which a module calls the class of a connection; None where a call is of none.

    `serial.Serial()` -> ("serial", "Serial"), after `from serial import Serial` `Serial()` -> ("Serial", "").
    """
    if not isinstance(node, ast.Call) or imported_name(module, node.func).partition(".")[0] not in MODULES:
        return None
    if isinstance(node.func, ast.Name):
        return node.func.id, ""
    if isinstance(node.func, ast.Attribute) and isinstance(node.func.value, ast.Name):
        return node.func.value.id, node.func.attr
    return None


def sent(node: ast.Call, name: str) -> ast.expr | None:
    """What a call sends: its payload."""
    arguments = [*node.args, *(keyword.value for keyword in node.keywords if keyword.arg in ("payload", "data"))]
    if name == "publish":
        return arguments[1] if len(arguments) > 1 else None
    return arguments[0] if arguments else None
