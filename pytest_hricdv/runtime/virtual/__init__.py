"""Python's own ways to wait, and its clocks, in virtual time, as seen from the modules under test."""

from pytest_hricdv.runtime.blocking_calls import KINDS
from pytest_hricdv.runtime.virtual.modules import VirtualModules
from pytest_hricdv.runtime.virtual.real_time import RealTimeError

__all__ = ["KINDS", "RealTimeError", "VirtualModules"]
