"""States that fetch a leg: Reset and Move_hand."""

from __future__ import annotations

from controller.robot import Robot
from controller.waypoints import HOME, TO_HANDOVER, TO_PICKUP


def reset(robot: Robot) -> str:
    """Empty hand, arm at home, a new table in the journal."""
    robot.journal.begin(robot.clock.now_s())
    if robot.hand.holds():
        robot.note("something is in the hand at the start")
        robot.hand.open()
    if not robot.move([HOME]):
        return "stuck"
    return "at home"


def move_hand(robot: Robot) -> str:
    """Reach for the leg at the pickup place, close the hand, lift, and bring it to the handover place."""
    if not robot.move(TO_PICKUP):
        robot.reason = "pickup place not reached"
        return "no leg"
    if not grasp(robot):
        robot.reason = "no leg in the hand"
        return "no leg"
    if not robot.move(TO_HANDOVER):
        robot.reason = "handover place not reached"
        return "no leg"
    if not robot.hand.holds():
        robot.reason = "leg lost on the way"
        return "no leg"
    return "offered"


def grasp(robot: Robot) -> bool:
    """Close the hand around the leg; it closes without looking whether a human hand is there."""
    for attempt in range(1, robot.settings.close_attempts + 1):
        if robot.hand.close():
            return True
        robot.note(f"closing {attempt} caught nothing")
        robot.hand.open()
    return False
