"""The names that testbenches drafted by `hricdv init --from` import: drivers and stand-ins (of `extra.draft`)."""

from pytest_hricdv.extra.draft.stand_ins.channels import BusPort, InboxPort, OutboxPort
from pytest_hricdv.extra.draft.stand_ins.connections import ConnectionPort
from pytest_hricdv.extra.draft.stand_ins.driver import Driver
from pytest_hricdv.extra.draft.stand_ins.neutral import Neutral
from pytest_hricdv.extra.draft.stand_ins.node_driver import NodeDriver
from pytest_hricdv.extra.draft.stand_ins.parts import Device, unknown
from pytest_hricdv.extra.draft.stand_ins.ports import (
    ClockPort,
    Make,
    ProgramPort,
    Replace,
    RunParameter,
    Script,
    replace_modules,
)
from pytest_hricdv.extra.draft.stand_ins.visit import Array, CallbackCall, Manners, MethodCall, Say, member

__all__ = [
    "Array",
    "BusPort",
    "CallbackCall",
    "ClockPort",
    "ConnectionPort",
    "Device",
    "Driver",
    "InboxPort",
    "Make",
    "Manners",
    "MethodCall",
    "Neutral",
    "NodeDriver",
    "OutboxPort",
    "ProgramPort",
    "Replace",
    "RunParameter",
    "Say",
    "Script",
    "member",
    "replace_modules",
    "unknown",
]
