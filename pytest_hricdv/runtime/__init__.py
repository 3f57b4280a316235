"""Virtual time for blocking robot nodes, a typed message bus, and the record of a run."""

from pytest_hricdv.runtime.bus import Bus, MessageFault, NodeBus, Subscription, topic_of
from pytest_hricdv.runtime.kernel import Kernel, Node
from pytest_hricdv.runtime.message_fields import fields_of, is_message
from pytest_hricdv.runtime.node_error import KernelError, NodeError
from pytest_hricdv.runtime.record import Record, RecordedMessage, Recorder, text_of
from pytest_hricdv.runtime.world import Body, World

__all__ = [
    "Body",
    "Bus",
    "Kernel",
    "KernelError",
    "MessageFault",
    "Node",
    "NodeBus",
    "NodeError",
    "Record",
    "RecordedMessage",
    "Recorder",
    "Subscription",
    "World",
    "fields_of",
    "is_message",
    "text_of",
    "topic_of",
]
