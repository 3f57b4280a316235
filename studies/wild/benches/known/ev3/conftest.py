from contextlib import suppress
from dataclasses import make_dataclass
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Testbench, Uniform, VirtualTime

HERE = Path(__file__).parent
PACKAGE = "ev3dev2" if (HERE / "src/ev3dev-lang-python/ev3dev2").exists() else "ev3dev"
STICK = {"ahead": (0, 100), "aside": (100, 0), "centre": (0, 0)}


Asked = make_dataclass("Asked", [("what", str)], frozen=True)
Done = make_dataclass("Done", [("left_deg", int), ("right_deg", int)], frozen=True)


def pytest_hricdv_testbench(config):
    commands = (*(f"stick {place}" for place in STICK), "turn ahead", "turn spin", "go_to here", "go_to there")
    return Testbench(
        name="ev3", model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(start=("one_drive", "two_drives"), groups={"drives_with": ("stick", "rotations", "positions")}),
        concretization=Concretization(commands=dict.fromkeys(commands, {"then_s": Uniform(0.3, 2.0, "s")})),
        requirements=HERE / "requirements.toml",
        messages=(Asked, Done), signals={"speed": float, "centred": bool},
        code=(f"{PACKAGE}.motor",), time=VirtualTime(apis=("time",), allowed_endings=("early",)),
        run=run,
    )


def run(run):
    import_module(PACKAGE).get_current_platform = lambda: "fake"
    motor = import_module(f"{PACKAGE}.motor")
    bus, motors = run.bus.port("tank"), []

    class Poll:  # the kernel notes a change of the state that was not read yet
        register = lambda self, *arguments: None

        def poll(self, timeout):
            until_s = run.kernel.now_s + (timeout or 1e9) / 1000
            while run.kernel.now_s < until_s and all(each.is_settled() for each in motors):
                run.kernel.sleep(0.02)

    class Wheel(motor.LargeMotor):  # /sys/class/tacho-motor, as its driver documents it
        def __init__(self, port):
            self.values = {"count_per_rot": 360, "max_speed": 1050, "position": 0, "state": "", "speed_sp": 0}
            self.is_read, self.ends_s = True, motors.append(self) or 0.0
            super().__init__(port, port, True)

        def is_settled(self):
            if self.values["state"] == "running" and run.kernel.now_s >= self.ends_s:
                self.values.update(state="holding", position=self.target)
                self.is_read = False
            return self.is_read

        def _get_attribute(self, attribute, name):
            self.is_read = self.is_settled() or name == "state"
            return name, str(self.values.get(name, 0))

        def _set_attribute(self, attribute, name, value):
            self.values[name] = value if name in ("command", "stop_action") else int(value)
            if name == "command":
                speed, position = self.values["speed_sp"], self.values["position"]
                goal = self.values.get("position_sp", 0) + position * (value == "run-to-rel-pos")
                moves = value == "run-forever" or (value.startswith("run-to") and goal != position)
                self.target = goal if value.startswith("run-to") else position
                self.ends_s = run.kernel.now_s + (1e9 if value == "run-forever" else abs(goal - position) / max(abs(speed), 1))
                self.values["state"], self.is_read = ("running" if moves else "holding"), not moves
                run.recorder.signal(run.kernel.now_s, "speed", float(abs(speed) if value == "run-forever" else 0))
            return name

        _attribute_file_open = lambda self, name: name

    motor.select = SimpleNamespace(poll=Poll, POLLPRI=2)

    def program():
        for name, value in (("speed", 0.0), ("centred", True)):
            run.recorder.signal(0.0, name, value)
        joystick = getattr(motor, "MoveJoystick", motor.MoveTank)("outA", "outB", motor_class=Wheel)
        left, right = joystick.left_motor, joystick.right_motor
        for action in run.actions():
            verb, _, what = action.command.partition(" ")
            before = left.position, right.position, bus.publish(Asked(what))
            with suppress(AssertionError, TypeError, ValueError):
                if verb == "stick" and PACKAGE == "ev3dev2":
                    run.recorder.signal(run.kernel.now_s, "centred", what == "centre")
                    joystick.on(*STICK[what])
                elif verb == "turn":
                    motor.MoveTank.on_for_rotations(joystick, 20, 20 if what == "ahead" else -20, 1.35)
                elif verb == "go_to" and PACKAGE == "ev3dev2":
                    left.on_to_position(20, -120 if what == "there" else left.position)
            bus.publish(Done(left.position - before[0], right.position - before[1]))
            run.kernel.sleep(action.parameters["then_s"])
        run.kernel.stop("the program has ended")

    run.kernel.spawn("program", run.measured(program))
    return Outcome(run.go(limit_s=60.0))
