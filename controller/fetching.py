"""States that fetch a leg: Reset and Move_hand."""

from __future__ import annotations

from controller.robot import Robot
from controller.waypoints import HOME, TO_HANDOVER, TO_PICKUP


def reset(robot: Robot) -> str:
    """Empty hand, arm at home, a new table in the journal."""
    robot.journal.begin(robot.clock.now_s())
    if robot.hand.holds():
        robot.note("something is in the hand at the start")
        while not robot.hand.open():
            robot.clock.sleep(robot.settings.retry_s)
    return "at home" if robot.move([HOME]) else "stuck"


def move_hand(robot: Robot) -> str:
    """Fetch a leg and hold it out."""
    robot.reason = fetch(robot)
    return "no leg" if robot.reason else "offered"


def fetch(robot: Robot) -> str:
    """Reach for the leg at the pickup place, close the hand, lift, bring to the handover place; what went wrong.

    With the leg in the hand, whoever is in the way is waited for: from here no other way is taught that lifts it first.
    """
    if not robot.move(TO_PICKUP):
        return "pickup place not reached"
    if not grasp(robot):
        return "no leg in the hand"
    while robot.hand.holds() and not robot.move(TO_HANDOVER):
        robot.clock.sleep(robot.settings.retry_s)
    if not robot.hand.holds():
        return "leg lost on the way"
    return ""


def grasp(robot: Robot) -> bool:
    """Close the hand around the leg; it closes without looking whether a human hand is there."""
    for attempt in range(1, robot.settings.close_attempts + 1):
        if robot.hand.close():
            return True
        robot.note(f"closing {attempt} caught nothing")
        robot.hand.open()
    return False
