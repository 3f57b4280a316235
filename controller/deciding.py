"""States that sense and decide: Wait0, Sensing, Timeout3, Decide."""

from __future__ import annotations

from controller.journal import SENSING_TIMEOUT
from controller.ports import Reading
from controller.robot import Robot


def wait0(robot: Robot) -> str:
    """Let the person settle before the sensors are read."""
    robot.clock.sleep(robot.settings.settle_s)
    return "settled"


def sensing(robot: Robot) -> str:
    """Wait for one reading of the sensors."""
    readings = robot.bus.subscribe(Reading)
    try:
        robot.reading = readings.wait(robot.settings.sensing_timeout_s)
    finally:
        readings.close()
    return "timeout" if robot.reading is None else "sensed"


def timeout3(robot: Robot) -> str:
    """The sensors were silent."""
    robot.outcome = SENSING_TIMEOUT
    robot.reason = f"no reading within {robot.settings.sensing_timeout_s:.1f} s"
    robot.note(robot.reason)
    return "give up"


def decide(robot: Robot) -> str:
    """Release only when gaze, pressure and location all say that the person is ready, and a leg is there to release."""
    reading = robot.reading
    missing = []
    if reading is None or not reading.gaze:
        missing.append("gaze")
    if reading is None or not reading.pressure:
        missing.append("pressure")
    if reading is None or not reading.location:
        missing.append("location")
    if missing:
        robot.reason = "not ready: " + ", ".join(missing)
        return "not ready"
    if not robot.hand.holds():
        robot.reason = "leg pulled out of the hand"
        robot.note(robot.reason)
        return "not ready"
    return "ready"
