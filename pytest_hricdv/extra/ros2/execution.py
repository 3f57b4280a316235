"""ROS 2 in the execution of tests: what requirements can name of the graph, and `rclpy` in virtual time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from pytest_hricdv.declarations.ros2 import Ros2Error
from pytest_hricdv.execution.execution_feature import ExecutionFeature
from pytest_hricdv.extra.ros2.bridge import vocabulary
from pytest_hricdv.monitor.names import Kind
from pytest_hricdv.testbench import Testbench

if TYPE_CHECKING:
    from pytest_hricdv.extra.ros2.system import Ros2Overlay


class Ros2Execution(ExecutionFeature):
    """The ROS 2 system of a testbench, where it declares one."""

    def prepare(self, testbench: Testbench) -> None:
        """Let `rclpy` be imported in virtual time only.

        Raises:
            Ros2Error: there is no `rclpy`, it cannot be used, or PyYAML is missing.
        """
        if testbench.ros2 is None:
            return
        try:
            from pytest_hricdv.extra.ros2.system import prepare
        except ModuleNotFoundError as error:  # it needs PyYAML
            raise Ros2Error(f'ros2: {error}; install the extra: pip install "pytest-hricdv[ros2]"') from None
        prepare()

    def topics(self, testbench: Testbench) -> Mapping[str, Mapping[str, Kind]]:
        """Those of the graph, with services and actions. Raises Ros2Error for a wrong name or type."""
        return {} if testbench.ros2 is None else vocabulary(testbench.ros2)

    def middleware(self, testbench: Testbench) -> Ros2Overlay | None:
        """`rclpy` in virtual time, for one run. Raises Ros2Error as `prepare` does."""
        if testbench.ros2 is None:
            return None
        from pytest_hricdv.extra.ros2.system import Ros2Overlay

        return Ros2Overlay(testbench.ros2, testbench.code)

    def before_imports(self, testbench: Testbench) -> tuple[str, ...]:
        """What replaces the extension of `rclpy`."""
        return () if testbench.ros2 is None else ("pytest_hricdv.extra.ros2.overlay:replace_extension",)


EXECUTION = Ros2Execution()
