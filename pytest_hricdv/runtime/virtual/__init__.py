"""Python's own ways to wait, and its clocks, in virtual time, as seen from the modules under test."""

from pytest_hricdv.runtime.virtual.modules import VirtualModules
from pytest_hricdv.runtime.virtual.real_time import RealTimeError
from pytest_hricdv.runtime.waiting import KINDS

__all__ = ["KINDS", "RealTimeError", "VirtualModules"]
