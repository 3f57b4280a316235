"""`Ros2Execution`: what ROS 2 adds to the execution of tests if the testbench declares a ROS 2 system.

It is the `EXECUTION` of this feature (see `registry`). `prepare` checks the declaration before tests run, `topics`
returns the names that requirements may use, and `middleware` a `Ros2Overlay` for each run.
"""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from pytest_hricdv.declarations.ros2 import LaunchError, Ros2Error, RosNode
from pytest_hricdv.execution.execution_feature import ExecutionFeature
from pytest_hricdv.extra.ros2.bridge import vocabulary
from pytest_hricdv.monitor.node import Kind
from pytest_hricdv.testbench import Testbench

if TYPE_CHECKING:
    from pytest_hricdv.extra.ros2.system import Ros2Overlay


class Ros2Execution(ExecutionFeature):
    """The ROS 2 system of a testbench, where it declares one."""

    def prepare(self, testbench: Testbench) -> None:
        """Let `rclpy` be imported in virtual time only, and look for the executables that each run starts.

        Raises:
            Ros2Error: there is no `rclpy`, it cannot be used, or PyYAML is missing; an executable is not there.
        """
        if testbench.ros2 is None:
            return
        try:
            from pytest_hricdv.extra.ros2.executables import entry_point
            from pytest_hricdv.extra.ros2.system import prepare
        except ModuleNotFoundError as error:  # it needs PyYAML
            raise Ros2Error(f'ros2: {error}; install the extra: pip install "pytest-hricdv[ros2]"') from None
        prepare()
        for node in list_nodes(testbench.run):
            try:
                entry_point(node)
            except LaunchError as error:
                raise Ros2Error(f"ros2: {error}") from None

    def topics(self, testbench: Testbench) -> Mapping[str, Mapping[str, Kind]]:
        """The topics of the graph, with services and actions. Raises Ros2Error for a wrong name or type."""
        return {} if testbench.ros2 is None else vocabulary(testbench.ros2)

    def middleware(self, testbench: Testbench) -> Ros2Overlay | None:
        """`rclpy` in virtual time, for one run. Raises Ros2Error as `prepare` does."""
        if testbench.ros2 is None:
            return None
        from pytest_hricdv.extra.ros2.system import Ros2Overlay

        return Ros2Overlay(testbench.ros2, testbench.code)

    def before_imports(self, testbench: Testbench) -> tuple[str, ...]:
        """The modules that replace the extension of `rclpy`."""
        return () if testbench.ros2 is None else ("pytest_hricdv.extra.ros2.overlay:replace_extension",)


_CERTAIN = (ast.Expr, ast.Assign, ast.AnnAssign, ast.With, ast.Return)
"""Statements that a run reaches whatever the test is, if they stand in its first level."""


def list_nodes(run: object) -> Iterator[RosNode]:
    """The nodes that a run function starts in any test: it names them with constants, outside conditions."""
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(run)))  # type: ignore[arg-type]
    except (OSError, TypeError, SyntaxError, ValueError):
        return
    body = tree.body[0].body if tree.body and isinstance(tree.body[0], ast.FunctionDef) else []
    for call in (node for statement in body for node in _calls(statement)):
        if ast.unparse(call.func).rpartition(".")[2] != "RosNode":
            continue
        try:
            named = {part.arg: ast.literal_eval(part.value) for part in call.keywords if part.arg in _NAMING}
            if all(named.get(key) for key in ("package", "executable")):
                yield RosNode(**named)
        except (ValueError, LaunchError):  # it is computed, or wrong, which the run says
            continue


_NAMING = ("package", "executable", "workspace")


def _calls(node: ast.AST) -> Iterator[ast.Call]:
    if isinstance(node, ast.Call):
        yield node
    if isinstance(node, ast.stmt) and not isinstance(node, _CERTAIN):
        return
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, ast.IfExp | ast.BoolOp | ast.Lambda | ast.comprehension | ast.ListComp):
            yield from _calls(child)


EXECUTION = Ros2Execution()
