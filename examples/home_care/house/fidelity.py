"""How the base moves: by geometry, which is the default, or in MuJoCo; and films of either."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from house.base import PUSHES_N, Mechanics
from house.house import STEP_US, US_PER_S, House
from house.planar import Planar
from pytest_hricdv.testbench import Body, Camera, Film

if TYPE_CHECKING:
    from collections.abc import Sequence

ENGINES: Mapping[str, str] = {"planar": "", "mujoco": "house.dynamic"}
"""`Simulation.engines`: the planar base needs no package."""

TOLERANCES: Mapping[str, float] = {"S3": 0.1, "S4": PUSHES_N}
"""`Simulation.engine_tolerances`: by how much margins may differ (m/s, N). Motors take 0.1 s to slow down from full
speed; what they push with is part of the force in MuJoCo, but not of an impact's by the formula."""


def new_mechanics(engine: str) -> Mechanics:
    """The base's mechanics by their name in `ENGINES`; an empty one is the first."""
    if engine == "mujoco":
        from house.dynamic import Dynamic

        return Dynamic()
    return Planar()


def _camera(house: House) -> Camera:
    from house.picture import Camera as FromAbove

    return FromAbove(house)


def _bodies(house: House) -> Sequence[Body]:
    from house.picture import bodies

    return bodies(house)


FILM = Film(
    camera=_camera,
    moments={"ordered": "order", "takes": "food_held", "done": "completed"},
    state="state.name",
    period_s=STEP_US / US_PER_S,
    bodies=_bodies,
)
"""`Simulation.film`: pictures need Pillow, of the extra "film"."""
