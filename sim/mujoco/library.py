"""MuJoCo itself, and robots that it loads."""

from __future__ import annotations

from typing import Any

from sim.engine import SimulationError

try:
    import mujoco as _mujoco
except ImportError as error:
    raise ImportError(f'this engine needs MuJoCo ({error}): pip install "pytest-hricdv[sim]"') from error

mujoco: Any = _mujoco
"""The MuJoCo module; what it says of its types is wrong in places."""

warnings: list[str] = []
"""What MuJoCo has warned of: else it would write a file into the working directory, and go on."""

mujoco.set_mju_user_warning(warnings.append)


def load(description: str) -> Any:
    """An `MjSpec` of a robot, from URDF text. Raises SimulationError where MuJoCo refuses it."""
    try:
        return mujoco.MjSpec.from_string(description)
    except ValueError as error:
        reason = str(error).splitlines()[0]
        raise SimulationError(f"MuJoCo refused the robot description {description[:80]!r}...: {reason}") from error
