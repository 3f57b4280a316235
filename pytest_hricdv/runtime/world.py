"""`World`: the interface of simulated worlds, which the `Kernel` advances while nodes wait; `Body`: a shape to view."""

from __future__ import annotations

import operator
from dataclasses import dataclass
from typing import Literal, Protocol, SupportsIndex

from pytest_hricdv._base.message import quote
from pytest_hricdv.runtime.node_error import KernelError

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


@dataclass(frozen=True)
class Body:
    """A coloured shape where it is now.

    Args:
        name: the same as long as it is the same body.
        shape: the axis of a cylinder is its own z axis.
        size_m: its extents along its own axes (m).
        position_m: the position of its middle, in the world (m).
        rotation: from its own axes to the world's, a unit quaternion (x, y, z, w).
        rgba: its colour, each part from 0 to 1.
    """

    name: str
    shape: Literal["box", "sphere", "cylinder"]
    size_m: Vector
    position_m: Vector
    rotation: Quaternion = (0.0, 0.0, 0.0, 1.0)
    rgba: tuple[float, ...] = (0.6, 0.6, 0.6, 1.0)


__tracebackhide__ = True  # a failing test shows the frames of its author


class World(Protocol):
    """The world that advances while the nodes wait: physics, or any other process."""

    def advance(self, target_us: int) -> int:
        """Advance at most to `target_us` and return the time reached (us).

        It returns early when something happened that nodes should see at once.
        """

    def observe(self) -> None:
        """Publish what happened; the kernel's clock has the time that `advance` returned."""


def advance_world(world: World, now_us: int, target_us: int) -> int:
    """Let a world advance from `now_us` at most to `target_us`; returns the time that it reached (us).

    Raises:
        KernelError: what it returned is no time, or lies outside.
    """
    reached_us = world.advance(target_us)
    if type(reached_us) is not int:
        reached_us = _whole_us(world, reached_us)
    if not now_us < reached_us <= target_us:
        raise KernelError(
            f"{_name(world)}, at {now_us} us and asked for {target_us} us, returned {reached_us} us; expected a time "
            f"after {now_us} us, and at most {target_us} us"
        )
    return reached_us


def _whole_us(world: World, reached_us: object) -> int:
    """The result of a world's `advance` as an integer; numpy's integers and whole floats are allowed.

    Raises:
        KernelError: it is not a whole number, such as the None of a function without `return`.
    """
    if isinstance(reached_us, SupportsIndex) and not isinstance(reached_us, bool):
        return operator.index(reached_us)
    if isinstance(reached_us, float) and reached_us.is_integer():
        return int(reached_us)
    raise KernelError(
        f"{_name(world)} returned {quote(reached_us)}; expected the time that the world has "
        "reached, in whole microseconds since the beginning of the run: return it, at most target_us"
    )


def _name(world: World) -> str:
    """The name of a world's `advance` in messages, with its place."""
    function = getattr(world.advance, "__func__", world.advance)
    code = getattr(function, "__code__", None)
    place = f"{code.co_filename}:{code.co_firstlineno}: " if code is not None else ""
    return f"{place}{type(world).__name__}.advance"
