"""Stand-ins of what surrounds code, with which a drafted testbench runs it."""

from pytest_hricdv.extra.draft.stand_ins.anything import Anything, replace_modules
from pytest_hricdv.extra.draft.stand_ins.channels import BusPort, InboxPort, OutboxPort
from pytest_hricdv.extra.draft.stand_ins.device import Device
from pytest_hricdv.extra.draft.stand_ins.driver import Clock, Drawn, Driver, Make, Replace
from pytest_hricdv.extra.draft.stand_ins.say import CallbackCall, MethodCall, Say, member
from pytest_hricdv.extra.draft.stand_ins.visit import Manners

__all__ = [
    "Anything",
    "BusPort",
    "CallbackCall",
    "Clock",
    "Device",
    "Drawn",
    "Driver",
    "InboxPort",
    "Make",
    "Manners",
    "MethodCall",
    "OutboxPort",
    "Replace",
    "Say",
    "member",
    "replace_modules",
]
