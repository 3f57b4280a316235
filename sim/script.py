"""The commands that a person can enact, and the parameters that each needs.

`tell leg`: `voice_s`, then the request is heard; `rest_x_m`, `rest_y_m`, `rest_z_m`, where the hand rests meanwhile.
`receivesignal`: none; waits for the robot's message that the leg is ready.
`set_param gaze = 1` or `0`: `offset_m`, `distance_m`, `angle_deg`, `side` (see `sim.gaze`).
`set_param location = 1` or `0`: `dx_m`, `dy_m`, `dz_m`, the hand's place relative to the leg's.
`set_param pressure = 1`: `pull_n`, `grip_s` (see `sim.person.Person`).
`set_param pressure = 0`: none; neither pulls nor grips.
`tell humanReady`: `voice_s`, then "ready" is heard.
`bored`: none; walks off and does nothing more until the next `tell leg`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from sim.engine import SimulationError, check_finite

Step = tuple[str, Mapping[str, float]]
"""A command with its parameters."""

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


def check_script(script: Iterable[Step]) -> Iterator[Step]:
    """The steps of a script, each of them a known command with its parameters as finite numbers.

    A sequence is checked here, before the first step; what is produced step by step, at each step.

    Raises:
        SimulationError: an unknown command, or a parameter that is missing or not finite.
    """
    if isinstance(script, Sequence):
        script = tuple((command, dict(parameters)) for command, parameters in script)
        for number, step in enumerate(script, 1):
            _check_step(number, *step)
    return _checked(script)


def _checked(script: Iterable[Step]) -> Iterator[Step]:
    for number, (command, parameters) in enumerate(script, 1):
        _check_step(number, command, parameters)
        yield command, parameters


def _check_step(number: int, command: str, parameters: Mapping[str, float]) -> None:
    if command not in PARAMETERS:
        raise SimulationError(f"step {number}: unknown command {command!r}; known are {sorted(PARAMETERS)}")
    missing = [name for name in PARAMETERS[command] if name not in parameters]
    if missing:
        raise SimulationError(f"step {number}: {command!r} lacks {missing}; it has {sorted(parameters)}")
    check_finite(f"step {number}: {command!r}", [parameters[name] for name in PARAMETERS[command]])
