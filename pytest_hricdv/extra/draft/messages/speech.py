"""Names of calls and callbacks by which code says and hears messages."""

from __future__ import annotations

import re

SAYS = (
    "publish", "send", "emit", "put", "put_nowait", "notify", "broadcast", "say", "post", "fire", "announce", "push",
    "send_nowait", "publish_message", "send_message", "sendto", "output", "report_event", "reply", "respond",
)  # fmt: skip
"""Names of calls that hand a message on, without leading underscores."""

SUBSCRIBES = (
    "subscribe", "on", "listen", "register", "add_listener", "register_handler", "add_handler", "wait_for", "expect",
    "receive", "recv", "create_subscription", "subscribe_to", "listen_to", "inbox", "register_callback",
)  # fmt: skip
"""Names of calls whose argument is the class of a message that comes, or its topic."""

TAKES = ("get", "get_nowait", "recv", "receive", "wait", "poll", "take", "popleft", "next", "read", "receive_nowait")
"""Names of calls that return a message."""

CALLBACK = re.compile(r"^_*(on|handle|handler|receive|received|process|cb|callback)_|_(cb|callback|handler|received)$")
"""Names of functions that a framework calls with a message."""

QUEUES = (
    "queue.Queue",
    "queue.SimpleQueue",
    "asyncio.Queue",
    "multiprocessing.Queue",
    "queue.PriorityQueue",
    "janus.Queue",
)

EVENTS = ("emit", "fire", "notify", "broadcast", "announce")
"""Names of calls all of whose further arguments go with an event: of others they say how it is to go."""

PAYLOADS = ("payload", "data", "message", "msg", "value", "body", "content")
"""Names of keywords by which a call hands over what goes with a topic; all others are fields of it."""

OPTIONS = ("qos", "retain", "properties", "timeout", "block")
"""Names of keywords that say how it is to go."""

SENDERS = ("topic", "event", "name", "channel", "sender", "client", "bus", "signal", "")
"""Names, without underscores, of the parameter before what a callback is called with."""

QUEUE_ONLY = ("get", "get_nowait", "empty", "qsize", "recv", "receive", "take", "task_done")
"""What a queue has, and a subscription of the plugin has not."""
