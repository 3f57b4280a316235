"""Welds of MuJoCo that give way beyond a force.

MuJoCo's own welds hold against any force. One that is overloaded is switched off: the body slides, against a force that
is as large as the weld can bear (Coulomb's dry friction), and is welded again where it has come to rest.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from sim.engine import STEP_S
from sim.geometry import Pose, Vector
from sim.mujoco.body import turn, vector
from sim.mujoco.library import mujoco
from sim.mujoco.scene import Scene, weld_force
from sim.rotation import compose, relative

TIME_S = 2.0 * STEP_S
"""In which a weld corrects its error: the least for which MuJoCo is stable."""

HARD = (0.99, 0.999, 0.001, 0.5, 2.0)
"""MuJoCo's impedance of a weld: near to 1, the body hardly gives under a force."""

SPIN_RAD_S = 1.0
"""Of a body that is let go, about its own x axis: no grip opens everywhere at once. Without it a leg falls upright
and stands upright on the one before; PyBullet's contacts make it topple."""


class Weld:
    """A body that is welded to a link of another.

    Args:
        scene: that has both.
        holder: body and link that hold it.
        body: that is held.
        frame: its pose relative to the link's centre of mass.
        limit_n: beyond this force it gives way.
    """

    def __init__(self, scene: Scene, holder: tuple[int, int], body: int, frame: Pose, limit_n: float) -> None:
        self.limit_n = limit_n
        self.force_n: Vector = (0.0, 0.0, 0.0)
        self._scene = scene
        self._holder = holder
        self._body = body
        self._frame = frame
        self._sliding: Vector | None = None  # the direction
        self._offset: Vector = (0.0, 0.0, 0.0)  # from where it was welded
        self._equality = self._weld()

    @property
    def holds(self) -> bool:
        """False while the body slides."""
        return self._sliding is None

    def remove(self) -> None:
        """Remove the weld; the body turns a little."""
        self._scene.velocity(self._body)[3] += SPIN_RAD_S
        self._scene.change().delete(self._equality)

    def before_step(self) -> None:
        """Resist a body that slides."""
        if self._sliding is not None:
            x, y, z = self.force_n = scaled(self.limit_n, self._sliding)
            place = self._scene.pose(self._body)[0]
            self._scene.push(self._body, -1, (-x, -y, -z), place)
            self._scene.push(*self._holder, self.force_n, place)

    def after_step(self, number: int) -> None:
        """Give way, or hold again.

        Args:
            number: among the welds that hold.
        """
        if self._sliding is None:
            _, data = self._scene.now()
            x, y, z = self.force_n = weld_force(data, number)
            load_n = math.hypot(x, y, z)
            if load_n > self.limit_n:
                self._sliding, self._offset = scaled(1.0 / load_n, self.force_n), self._offset_now()
                self._let_go()
            return
        before, self._offset = self._offset, self._offset_now()
        moved = tuple(now - then for now, then in zip(self._offset, before, strict=True))
        if sum(m * s for m, s in zip(moved, self._sliding, strict=True)) > 0.0:
            self._sliding = scaled(1.0 / math.hypot(*moved), moved)
        else:
            self._sliding = None
            self._hold_here()

    def _holder_pose(self) -> Pose:
        """Of the holding link's centre of mass."""
        body, link = self._holder
        _, data = self._scene.placed(body)
        number = self._scene.bodies[body].numbers.links[link]
        return vector(data.xipos[number]), turn(data.xquat[number])

    def _offset_now(self) -> Vector:
        """From where the body was welded to where it is (m)."""
        (tx, ty, tz), _ = compose(self._holder_pose(), self._frame)
        x, y, z = self._scene.pose(self._body)[0]
        return (x - tx, y - ty, z - tz)

    def _hold_here(self) -> None:
        self._frame = relative(self._holder_pose(), self._scene.pose(self._body))
        self._scene.change().delete(self._equality)
        self._equality = self._weld()

    def _let_go(self) -> None:
        _, data = self._scene.now()
        self._equality.active = False  # for the next compilation
        data.eq_active[self._equality.id] = False

    def _weld(self) -> Any:
        body, link = self._holder
        model, _ = self._scene.having(body)
        place = model.body_ipos[self._scene.bodies[body].numbers.links[link]] + self._frame[0]
        x, y, z, w = self._frame[1]
        holder = self._scene.bodies[body]
        return self._scene.change().add_equality(
            type=mujoco.mjtEq.mjEQ_WELD,
            objtype=mujoco.mjtObj.mjOBJ_BODY,
            name1=(holder.base if link < 0 else holder.links[link]).name,
            name2=self._scene.bodies[self._body].base.name,
            data=[0.0, 0.0, 0.0, *place, w, x, y, z, 1.0, 0.0],
            solref=(TIME_S, 1.0),
            solimp=HARD,
        )


def scaled(share: float, values: Sequence[float]) -> Vector:
    """Three numbers, all multiplied by another one."""
    x, y, z = values
    return (share * x, share * y, share * z)
