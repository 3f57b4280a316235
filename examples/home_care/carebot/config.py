"""What can be set: speeds, distances, times, and the published faults, which are off."""

from __future__ import annotations

from dataclasses import dataclass, fields

STOPS_ON_EITHER = "stop-on-either"
LOSES_ORDERS = "lost-when-busy"
NEVER_IDLE_FIRST = "never-idle-first"
WAITS_FOR_EVER = "waits-for-ever"
TRUSTS_GRIPPER = "trusts-gripper"


@dataclass(frozen=True)
class Faults:
    """What the published program did wrong, each to be switched on.

    Args:
        stops_on_either: on its ways, which are straight but for the doorway between the rooms, driving to the doorway
            or to the goal ends as soon as one coordinate is right, instead of both.
        loses_orders: an order that comes while another one is carried out is lost.
        never_idle_first: the robot never becomes idle before its first order.
        waits_for_ever: with somebody near it stays where it is, without limit, and looks for no other way.
        trusts_gripper: when the gripper has closed, it takes something for held, whatever is in it; opened likewise.
    """

    stops_on_either: bool = False
    loses_orders: bool = False
    never_idle_first: bool = False
    waits_for_ever: bool = False
    trusts_gripper: bool = False


SWITCHES = dict(
    zip(
        (STOPS_ON_EITHER, LOSES_ORDERS, NEVER_IDLE_FIRST, WAITS_FOR_EVER, TRUSTS_GRIPPER),
        (field.name for field in fields(Faults)),
        strict=True,
    )
)
"""How each fault is called on a command line."""


def faults(names: str) -> Faults:
    """The faults of a comma-separated list of `SWITCHES`; empty for none.

    Raises:
        ValueError: a name that is none of them.
    """
    chosen = [name.strip() for name in names.split(",") if name.strip()]
    for name in chosen:
        if name not in SWITCHES:  # unreachable: no fault is on
            listed = ", ".join(SWITCHES)  # unreachable: no fault is on
            raise ValueError(f"no fault {name!r}; expected some of {listed}")  # unreachable: no fault is on
    return Faults(**{SWITCHES[name]: True for name in chosen})


@dataclass(frozen=True)
class Config:
    """The robot's settings. Published ones are from the home-care case; the others are chosen.

    Args:
        speed_m_s: when it drives (published: 0.25, which its own monitor does not allow to be reached).
        near_speed_m_s: when anything that its map does not have is within `near_m` (chosen: half of it).
        turn_rad_s: when it turns on the spot (published).
        period_s: of its control loop (chosen: 5 cm of driving).
        near_m: from the laser (chosen).
        stop_m: how far ahead of its hull the way has to be free (chosen: more than it drives in a second).
        idle_after_s: without an order it is idle (published).
        patience_s: so long it waits for somebody to leave its way before it looks for another one (chosen).
        give_up_s: so long it may take longer than the way does, before the order is given up (chosen).
        gripper_limit_s: for closing and for opening (published: 2.5 s and 3 s, each with a limit of 3 s).
        gripper_period_s: how often it looks how far the gripper is (chosen: a tenth of its way).
        queue: so many orders may wait (chosen).
        order_limit_s: so long after it was accepted an order is carried out, or given up (chosen: longer than five
            orders take one after the other where nobody is in the way).
        battery_low: below, it is charged before the next order (chosen).
        battery_enough: so far (chosen).
        faults: what it does wrong.
    """

    speed_m_s: float = 0.24
    near_speed_m_s: float = 0.12
    turn_rad_s: float = 0.5
    period_s: float = 0.2
    near_m: float = 1.2
    stop_m: float = 0.3
    idle_after_s: float = 30.0
    patience_s: float = 4.0
    give_up_s: float = 60.0
    gripper_limit_s: float = 4.0
    gripper_period_s: float = 0.25
    queue: int = 5
    order_limit_s: float = 840.0
    battery_low: float = 0.2
    battery_enough: float = 0.22
    faults: Faults = Faults()
