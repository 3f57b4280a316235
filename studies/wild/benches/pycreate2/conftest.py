import sys
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from types import SimpleNamespace

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Testbench, Uniform, VirtualTime

HERE = Path(__file__).parent
SIZES = {128: 0, 131: 0, 132: 0, 133: 0, 137: 4, 139: 3, 141: 1, 142: 1, 145: 4, 146: 4, 164: 4, 173: 0}  # bytes of data
SONGS = {"long": [60, 16] * 16 + [137, 1, 44, 128, 0, 16], "wrong": [60, 16]}
port = SimpleNamespace(sent=None, answer=b"")
version = metadata.version
metadata.version = lambda name: "0.8.2" if name == "pycreate2" else version(name)  # it is not installed
sys.modules["serial"] = SimpleNamespace(Serial=lambda: Serial())


class Serial:
    is_open = True
    open = close = lambda self: None
    write = lambda self, data: port.sent(data)
    read = lambda self, size: port.answer[:size]


@dataclass(frozen=True)
class Refused:
    """A call has raised an error."""


@dataclass(frozen=True)
class Asked:
    """The program asks for a song with too many notes, or of a wrong number."""


def pytest_hricdv_testbench(config):
    commands = ("drive fast", "drive back", "look short", *(f"sing {name}" for name in SONGS))
    return Testbench(
        name="pycreate2",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(start=("one_drive", "two_drives"),
                            groups={"does": ("drives", "sings_long", "sings_wrong", "looks")}),
        concretization=Concretization(commands=dict.fromkeys(commands, {"then_s": Uniform(0.2, 2.0, "s")})),
        requirements=HERE / "requirements.toml",
        messages=(Refused, Asked),
        signals={"speed": float, "may_drive": bool, "has_ended": bool},
        code=("pycreate2",),
        time=VirtualTime(apis=("time",), allowed_endings=("early",)),
        run=run,
    )


def run(run):
    from pycreate2 import Create2

    bus, todo = run.bus.port("robot"), []

    record = lambda name, value: run.recorder.signal(run.kernel.now_s, name, value)

    def obey(data):  # as the robot: an opcode, its data, the next opcode; a song holds 16 notes
        todo.extend(data)
        while todo:
            size = 2 + 2 * min(todo[2], 16) if todo[0] == 140 and len(todo) > 2 else SIZES.get(todo[0], 0)
            if todo[0] in (137, 145, 146):
                record("speed", float(abs(int.from_bytes(bytes(todo[1:3]), signed=True))))
            del todo[:1 + size]

    port.sent, port.answer = obey, bytes(30)

    def program():
        record("speed", 0.0)
        record("may_drive", False)
        record("has_ended", False)
        robot = Create2("/dev/robot")
        robot.start()
        robot.safe()
        for action in run.actions():
            verb, _, what = action.command.partition(" ")
            try:
                if verb == "drive":
                    record("may_drive", True)
                    robot.drive_direct(*{"fast": (900, 900), "back": (-200, -200)}[what])
                elif verb == "sing":
                    bus.publish(Asked())
                    robot.createSong(7 if what == "wrong" else 0, SONGS[what])
                else:
                    robot.get_sensors()
            except Exception:
                bus.publish(Refused())
            run.kernel.sleep(action.parameters["then_s"])
        robot.__del__()
        record("has_ended", True)
        run.kernel.sleep(1.0)
        run.kernel.stop("the program has ended")

    run.kernel.spawn("program", run.measured(program))
    return Outcome(run.go(limit_s=120.0))
