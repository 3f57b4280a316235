"""The commands that a person can enact, and the parameters that each needs.

`tell leg`: `voice_s`, then the request is heard; `rest_x_m`, `rest_y_m`, `rest_z_m`, where the hand rests meanwhile.
`receivesignal`: none; waits for the robot's message that the leg is ready.
`set_param gaze = 1` or `0`: `offset_m`, `distance_m`, `angle_deg`, `side` (see `sim.gaze`).
`set_param location = 1` or `0`: `dx_m`, `dy_m`, `dz_m`, the hand's place relative to the leg's.
`set_param pressure = 1`: `pull_n`, `grip_s` (see `sim.person.Person`).
`set_param pressure = 0`: none; neither pulls nor grips.
`tell humanReady`: `voice_s`, then "ready" is heard.
`bored`: none; walks off and does nothing more until the next `tell leg`.
`disturb ...`: nothing that the person does; whatever it is happens when the person comes to it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from sim.engine import SimulationError, check_finite

Script = tuple[tuple[str, Mapping[str, float]], ...]

PARAMETERS: Mapping[str, tuple[str, ...]] = {
    "tell leg": ("voice_s", "rest_x_m", "rest_y_m", "rest_z_m"),
    "receivesignal": (),
    "set_param gaze = 1": ("offset_m", "distance_m", "angle_deg", "side"),
    "set_param gaze = 0": ("offset_m", "distance_m", "angle_deg", "side"),
    "set_param location = 1": ("dx_m", "dy_m", "dz_m"),
    "set_param location = 0": ("dx_m", "dy_m", "dz_m"),
    "set_param pressure = 1": ("pull_n", "grip_s"),
    "set_param pressure = 0": (),
    "tell humanReady": ("voice_s",),
    "bored": (),
}
"""The ten commands. Case study."""

DISTURB = "disturb "
"""How the line of a disturbance begins."""


def check_script(script: Sequence[tuple[str, Mapping[str, float]]]) -> Script:
    """The script, if every command is known and has its parameters as finite numbers.

    Raises:
        SimulationError: an unknown command, or a parameter that is missing or not finite.
    """
    for number, (command, parameters) in enumerate(script, 1):
        if command.startswith(DISTURB):
            continue
        if command not in PARAMETERS:
            raise SimulationError(f"step {number}: unknown command {command!r}; known are {sorted(PARAMETERS)}")
        missing = [name for name in PARAMETERS[command] if name not in parameters]
        if missing:
            raise SimulationError(f"step {number}: {command!r} lacks {missing}; it has {sorted(parameters)}")
        check_finite(f"step {number}: {command!r}", [parameters[name] for name in PARAMETERS[command]])
    return tuple((command, dict(parameters)) for command, parameters in script)
