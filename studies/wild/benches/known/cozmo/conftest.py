import struct
import sys
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import MagicMock

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Testbench, Uniform, VirtualTime

HERE = Path(__file__).parent
sys.modules.update(dict.fromkeys(("dpkt", "flatbuffers", "flatbuffers.number_types", "PIL", "PIL.Image"), MagicMock()))


@dataclass(frozen=True)
class Asked:
    mmps: float


@dataclass(frozen=True)
class Wheels:
    left_mmps: float
    right_mmps: float


@dataclass(frozen=True)
class Done:
    """The call has come back."""


def pytest_hricdv_testbench(config):
    drive = {"mmps": Uniform(20.0, 100.0, "mm/s"), "for_s": Uniform(0.3, 2.0, "s")}
    return Testbench(
        name="cozmo",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(start=("one_game", "two_games"), groups={"play": ("drives", "spins", "lifts", "stops")}),
        concretization=Concretization(commands={"drive ahead": drive, "drive spin": drive, "stop": {}, "lift": {},
                                                "rest": {"for_s": Uniform(0.2, 1.0, "s")}}),
        requirements=HERE / "requirements.toml",
        messages=(Asked, Wheels, Done),
        signals={"speed": float},
        code=("pycozmo.client",),
        time=VirtualTime(apis=("time", "threading"), allowed_endings=("early",)),
        run=run,
    )


def run(run):
    from pycozmo import client, protocol_encoder

    bus = run.bus.port("robot")

    def wheels(left, right):
        run.recorder.signal(run.kernel.now_s, "speed", float(max(abs(left), abs(right))))

    def send(packet):  # as the robot: four floats are the speeds and accelerations of its tracks
        data = packet.to_bytes()
        if isinstance(packet, protocol_encoder.DriveWheels):
            left, right, _, _ = struct.unpack("<4f", data)
            bus.publish(Wheels(left, right))
            wheels(left, right)
        elif isinstance(packet, protocol_encoder.StopAllMotors):
            wheels(0, 0)

    client.conn = SimpleNamespace(ClientConnection=lambda *arguments: SimpleNamespace(send=send))

    def program():
        wheels(0, 0)
        robot = client.Client()
        for action in run.actions():
            verb, _, how = action.command.partition(" ")
            if verb == "drive":
                speed = action.parameters["mmps"]
                bus.publish(Asked(speed))
                try:
                    robot.drive_wheels(speed, speed if how == "ahead" else -speed, duration=action.parameters["for_s"])
                except Exception:
                    run.kernel.sleep(action.parameters["for_s"])
                bus.publish(Done())
                run.kernel.sleep(0.02)
            elif verb == "rest":
                run.kernel.sleep(action.parameters["for_s"])
            else:
                robot.stop_all_motors() if verb == "stop" else robot.move_lift(1.0)
        run.kernel.sleep(1.0)
        run.kernel.stop("the game is over")

    run.kernel.spawn("program", run.measured(program))
    return Outcome(run.go(limit_s=60.0))
