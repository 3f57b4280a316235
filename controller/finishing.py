"""States that end a turn: Release and Discard."""

from __future__ import annotations

from controller.journal import RELEASED
from controller.robot import Robot
from controller.waypoints import HOME, TO_RESUPPLY


def release(robot: Robot) -> str:
    """Open the hand and make sure that it is open; try again after a while for as long as it is not.

    It is not closed again: a person who keeps it from opening has a hand there.
    """
    attempt = 1
    while not robot.hand.open():
        robot.clock.sleep(robot.settings.retry_s)
        attempt += 1
    robot.outcome = RELEASED
    if attempt > 1:
        robot.reason = f"released at attempt {attempt}"
        robot.note(robot.reason)
    retreat(robot)
    return next_turn(robot)


def discard(robot: Robot) -> str:
    """Take the leg away from the person to the re-supply place and drop it there.

    Whoever is in the way, or holds the fingers, is waited for: dropped elsewhere, a leg falls on somebody or is handed
    over, and with a leg in the hand the arm does not go home.
    """
    if not robot.hand.holds():
        robot.note("nothing to discard")
    while not emptied(robot):
        robot.clock.sleep(robot.settings.retry_s)
    retreat(robot)
    return next_turn(robot)


def emptied(robot: Robot) -> bool:
    """Open the hand, over the re-supply place if it holds a leg; whether it is open."""
    if robot.hand.holds() and not robot.move(TO_RESUPPLY):
        robot.note("no way to discard the leg yet")
        return False
    return robot.hand.open()


def retreat(robot: Robot) -> None:
    """Bring the arm home."""
    if not robot.move([HOME]):
        robot.note("arm stays where it is")


def next_turn(robot: Robot) -> str:
    """Every leg handed over or discarded counts."""
    robot.end_turn()
    if len(robot.journal.turns) < robot.settings.turns:
        robot.listen()
        return "next leg"
    settings = robot.settings
    robot.bus.publish(robot.journal.report(robot.clock.now_s(), settings.turns, settings.on_time_s))
    return "table done"
