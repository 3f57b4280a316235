"""PyBullet itself, without what it prints: clients, and robots that they load."""

from __future__ import annotations

import tempfile
from typing import Any

from sim.engine import SimulationError
from sim.silence import silenced

try:
    with silenced():  # its banner
        import pybullet
except ImportError as error:  # numpy missing counts too: PyBullet needs it without declaring it
    raise ImportError(
        f'the simulated world needs PyBullet and numpy ({error}): pip install "pytest-hricdv[sim]"'
    ) from error

bullet: Any = pybullet
"""The PyBullet module; it has no types."""


def connect() -> int:
    """A new client without a window."""
    with silenced():
        client: int = bullet.connect(bullet.DIRECT)
    if client < 0:
        raise SimulationError("PyBullet gave no client")
    return client


def load(client: int, description: str, flags: int) -> int:
    """The body of a robot with a fixed base.

    Args:
        client: that loads it.
        description: URDF text.
        flags: of `loadURDF`, beside that inertia is as described.
    """
    flags |= bullet.URDF_USE_INERTIA_FROM_FILE
    with tempfile.NamedTemporaryFile("w", suffix=".urdf", encoding="utf-8") as file, silenced():
        file.write(description)  # PyBullet wants a file
        file.flush()
        try:
            body: int = bullet.loadURDF(file.name, useFixedBase=True, flags=flags, physicsClientId=client)
        except bullet.error as error:
            raise SimulationError(f"PyBullet refused the robot description {description[:80]!r}...") from error
    return body
