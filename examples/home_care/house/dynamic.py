"""How the base moves and touches, in MuJoCo: with masses, motors that take time, and contacts that give way.

The base is a disc on two slides and a hinge; wheels are motors along and across its heading. All bodies lie in one
plane and are spheres and boxes, so that each contact is a single point, without friction. A contact is as stiff as
`house.base.BODIES` says; as person and dog are moved by their own will (mocap bodies, of infinite mass), their mass is
in the stiffness: the peak of an impact is that of `house.base.impact_n`, but for the contact's damping and the motors.

Importing it needs mujoco.
"""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np

from house.base import BODIES, FREE, MASS_KG, PUSHES_N, RADIUS_M, Base, Body, Contact
from house.flat import SOLIDS, clearance_m
from house.shapes import Box, turned
from house.walkers import DOG_SIZE_M, PERSON_RADIUS_M, Dog, Person

STEP_S = 0.002
"""Of physics: a contact of 80 ms has 40 of them; with half of it, forces of `tests/house` change by less than 1 %."""

SETTLES_S = 0.05
"""Time constant of the motors' speed (chosen: far below a period of the robot's code)."""

TRACK_M = 0.4044
"""Between the wheels, as the maker's public description of the base has it: for the torque that they turn with."""

GRIPS_N = 400.0
"""What wheels hold against, sideways: about 0.6 of the weight (chosen: rubber on parquet)."""

DAMPING = 0.5
"""Of contacts, of the critical one (chosen): who runs into a wall bounces off little."""

HALF_HEIGHT_M = 0.5
"""Of boxes; all bodies have their middles at one height."""

STILL_M_S = 1e-4
"""Slower than this, in m/s or rad/s, without a command or a contact, the base stands."""

NEAR_M = 0.02
"""With anything this near, each step of physics is looked at; else several are made at once."""

_US_PER_STEP = round(STEP_S * 1e6)


class Dynamic:
    """A base of a mass, with motors of limited force; the same methods as `house.planar.Planar`."""

    def __init__(self) -> None:
        self._model: Any = mujoco.MjModel.from_xml_string(_scene())
        self._data: Any = mujoco.MjData(self._model)
        self._kinds = {
            mujoco.mj_name2id(self._model, mujoco.mjtObj.mjOBJ_GEOM, name): kind for name, kind, _ in _obstacles()
        }
        self._person, self._dog = 0, 1  # numbers of the mocap bodies, in the scene's order
        self._left_us = 0
        self._last: tuple[object, float] = ((0.0, 0.0), 0.0)
        self._force = np.zeros(6)

    def moved(self, base: Base) -> None:
        """The base was set somewhere else: it stands there."""
        self._data.qpos[:] = (*base.at, base.heading_rad)
        self._data.qvel[:] = 0.0

    def step(self, base: Base, person: Person, dog: Dog, duration_s: float) -> Contact:
        """Let the base move for a while as it is told; by whole steps of physics, what is left comes next time."""
        if self._last != (base.at, base.heading_rad):
            self.moved(base)
        self._place(person, dog)
        self._data.ctrl[:] = (base.forward_m_s, 0.0, base.turn_rad_s)
        start, self._left_us = base.at, self._left_us + round(duration_s * 1e6)
        steps, self._left_us = divmod(self._left_us, _US_PER_STEP)
        contact = self._advance(steps, self._is_near(base, person, dog, duration_s))
        self._rest(base, contact)
        x, y, heading = self._data.qpos.tolist()
        if (x, y) != base.at:
            base.at = (x, y)
        base.heading_rad = turned(heading)
        self._last = (base.at, base.heading_rad)
        base.speed_m_s = math.dist(start, base.at) / duration_s if steps else base.speed_m_s
        base.turning_rad_s = abs(float(self._data.qvel[2]))
        return contact

    def _place(self, person: Person, dog: Dog) -> None:
        self._data.mocap_pos[self._person, :2] = person.at
        self._data.mocap_pos[self._dog, :2] = dog.at
        half_rad = dog.heading_rad / 2.0
        self._data.mocap_quat[self._dog] = (math.cos(half_rad), 0.0, 0.0, math.sin(half_rad))

    def _is_near(self, base: Base, person: Person, dog: Dog, duration_s: float) -> bool:
        way_m = max(abs(base.forward_m_s), float(np.hypot(*self._data.qvel[:2]))) * duration_s
        gaps_m = (
            clearance_m(base.at) - base.radius_m,
            person.gap_to(base.at, base.radius_m).width_m,
            dog.gap_to(base.at, base.radius_m).width_m,
        )
        return min(gaps_m) < NEAR_M + way_m

    def _advance(self, steps: int, is_near: bool) -> Contact:
        """Make steps; the contact with the greatest force of them."""
        if not is_near:
            mujoco.mj_step(self._model, self._data, steps)
            return FREE
        worst = FREE
        for _ in range(steps):
            mujoco.mj_step(self._model, self._data)
            for number in range(self._data.ncon):
                contact = self._touched(number)
                if contact.force_n > worst.force_n:
                    worst = contact
        return worst

    def _touched(self, number: int) -> Contact:
        pair = self._data.contact[number]
        mujoco.mj_contactForce(self._model, self._data, number, self._force)
        kind = self._kinds.get(int(pair.geom1)) or self._kinds[int(pair.geom2)]
        return Contact(kind, float(self._force[0]))

    def _rest(self, base: Base, contact: Contact) -> None:
        """A base that hardly moves any more, and is not to, stands."""
        is_told = base.forward_m_s != 0.0 or base.turn_rad_s != 0.0
        if not is_told and contact is FREE and float(np.abs(self._data.qvel).max()) < STILL_M_S:
            self._data.qvel[:] = 0.0


def _obstacles() -> list[tuple[str, str, Body]]:
    """Names of geoms that the base may touch, what they are, and how they give way."""
    solids = [(solid.name, solid.kind, BODIES[solid.kind]) for solid in SOLIDS]
    return [*solids, ("person", "person", BODIES["person"]), ("dog", "dog", BODIES["dog"])]


def _scene() -> str:
    inertia = MASS_KG * RADIUS_M**2 / 2.0  # of a disc
    boxes = "".join(_box(solid.name, solid.box) for solid in SOLIDS)
    pairs = "".join(_pair(name, body) for name, _, body in _obstacles())
    dog_x, dog_y = DOG_SIZE_M[0] / 2.0, DOG_SIZE_M[1] / 2.0
    damps, turns_nm = MASS_KG / SETTLES_S, PUSHES_N * TRACK_M / 2.0
    return f"""
<mujoco>
  <option timestep="{STEP_S}" gravity="0 0 0" integrator="implicitfast"/>
  <default><geom contype="0" conaffinity="0"/></default>
  <worldbody>
    {boxes}
    <body name="base">
      <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/><joint type="hinge" axis="0 0 1"/>
      <inertial pos="0 0 0" mass="{MASS_KG}" diaginertia="{inertia} {inertia} {inertia}"/>
      <geom name="hull" type="sphere" size="{RADIUS_M}"/>
      <site name="wheels"/>
    </body>
    <body name="person" mocap="true"><geom name="person" type="sphere" size="{PERSON_RADIUS_M}"/></body>
    <body name="dog" mocap="true"><geom name="dog" type="box" size="{dog_x} {dog_y} {HALF_HEIGHT_M}"/></body>
  </worldbody>
  <contact>{pairs}</contact>
  <actuator>
    <velocity site="wheels" gear="1 0 0 0 0 0" kv="{damps}" forcerange="-{PUSHES_N} {PUSHES_N}"/>
    <velocity site="wheels" gear="0 1 0 0 0 0" kv="{damps}" forcerange="-{GRIPS_N} {GRIPS_N}"/>
    <velocity site="wheels" gear="0 0 0 0 0 1" kv="{inertia / SETTLES_S}" forcerange="-{turns_nm} {turns_nm}"/>
  </actuator>
</mujoco>
"""


def _box(name: str, box: Box) -> str:
    x, y = (box.x1 + box.x2) / 2.0, (box.y1 + box.y2) / 2.0
    size = f"{(box.x2 - box.x1) / 2.0} {(box.y2 - box.y1) / 2.0} {HALF_HEIGHT_M}"
    return f'<geom name="{name}" type="box" pos="{x} {y} 0" size="{size}"/>'


def _pair(name: str, body: Body) -> str:
    reduced_kg = 1.0 / (1.0 / MASS_KG + 1.0 / body.mass_kg)
    # MuJoCo wants stiffness and damping of an acceleration; see the module's text for the mass of who is met.
    per_s2 = reduced_kg * body.stiffness_n_m / MASS_KG**2
    per_s = 2.0 * DAMPING * math.sqrt(per_s2)
    return f'<pair geom1="hull" geom2="{name}" condim="1" solref="-{per_s2} -{per_s}" solimp="0.999 0.999 0.001"/>'
