"""Python's blocking APIs and clocks in virtual time, as the modules under test see them."""

from pytest_hricdv.runtime.blocking_calls import KINDS
from pytest_hricdv.runtime.virtual.modules import VirtualModules
from pytest_hricdv.runtime.virtual.real_time import RealTimeError

__all__ = ["KINDS", "RealTimeError", "VirtualModules"]
