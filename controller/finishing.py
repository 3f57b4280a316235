"""States that end a turn: Release and Discard."""

from __future__ import annotations

from controller.journal import RELEASED
from controller.robot import Robot
from controller.waypoints import HOME, TO_RESUPPLY


def release(robot: Robot) -> str:
    """Open the hand and make sure that it is open; try again after a while when it is not.

    A robot that gives up closes its hand, or the leg would fall on the way to the re-supply place.
    """
    for attempt in range(1, robot.settings.release_attempts + 1):
        if attempt > 1:
            robot.clock.sleep(robot.settings.release_retry_s)
        if robot.hand.open():
            robot.outcome = RELEASED
            if attempt > 1:
                robot.reason = f"released at attempt {attempt}"
                robot.note(robot.reason)
            retreat(robot)
            return next_turn(robot)
    robot.reason = "the fingers did not open"
    robot.note(robot.reason)
    robot.hand.close()
    return "stuck"


def discard(robot: Robot) -> str:
    """Take the leg away from the person to the re-supply place and drop it there."""
    if robot.hand.holds():
        if not robot.move(TO_RESUPPLY):
            robot.note("discarding where the arm stands")
        if not robot.hand.open():
            robot.note("leg stays in the hand")
    else:
        robot.note("nothing to discard")
        robot.hand.open()
    retreat(robot)
    return next_turn(robot)


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
