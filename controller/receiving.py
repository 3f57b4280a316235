"""States that listen and speak: Receive1, Timeout1, Send1, Receive2, Timeout2."""

from __future__ import annotations

from controller.journal import NO_HUMAN_READY
from controller.ports import LegReady
from controller.robot import Robot


def receive1(robot: Robot) -> str:
    """Wait for the person's request."""
    for _ in range(robot.settings.receive_polls):
        if robot.requests.poll() is not None:
            robot.begin_turn()
            return "request"
        robot.clock.sleep(robot.settings.request_poll_s)
    return "timeout"


def timeout1(robot: Robot) -> str:
    """Nobody asked: note it once a table, and go on waiting."""
    text = "nobody asks"
    if not any(text in note for note in robot.journal.notes):
        robot.note(text)
    return "wait on"


def send1(robot: Robot) -> str:
    """Tell the person that the leg is held out."""
    robot.readies.clear()
    robot.bus.publish(LegReady(robot.turn))
    return "told"


def receive2(robot: Robot) -> str:
    """Wait for the person's "ready"."""
    for _ in range(robot.settings.receive_polls):
        if robot.readies.poll() is not None:
            return "ready"
        robot.clock.sleep(robot.settings.ready_poll_s)
    return "timeout"


def timeout2(robot: Robot) -> str:
    """The person did not answer."""
    patience_s = robot.settings.receive_polls * robot.settings.ready_poll_s
    robot.outcome = NO_HUMAN_READY
    robot.reason = f"no answer within {patience_s:.0f} s"
    robot.note(robot.reason)
    return "give up"
