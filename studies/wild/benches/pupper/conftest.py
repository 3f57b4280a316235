import importlib
import sys
from dataclasses import dataclass
from pathlib import Path

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Testbench, Uniform, VirtualTime

HERE = Path(__file__).parent


@dataclass(frozen=True)
class Pressed:
    button: str


def pytest_hricdv_testbench(config):
    commands = ("press l1", "press r1", "press x", "stick ahead", "stick zero", "link lost", "link back")
    return Testbench(
        name="pupper",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(start=("one_walk", "two_walks"), groups={"manner": ("tidy", "hasty", "hops", "lost")}),
        concretization=Concretization(commands=dict.fromkeys(commands, {"for_s": Uniform(0.5, 2.0, "s")})),
        requirements=HERE / "requirements.toml",
        messages=(Pressed,),
        signals={"stepping": bool, "is_off": bool},
        code=("run_robot", "src", "pupper"),
        time=VirtualTime(apis=("time",)),
        run=run,
    )


def run(run):
    import UDPComms

    bus, servos, last = run.bus.port("joystick"), {}, [-1.0]
    idle = {"R1": 0, "L1": 0, "x": 0, "ly": 0.0, "lx": 0.0, "rx": 0.0, "ry": 0.0, "dpadx": 0, "dpady": 0}
    UDPComms.message, UDPComms.sleep = {**idle, "message_rate": 20}, run.kernel.sleep

    def moved(pin, value):
        if servos.setdefault(pin, value) != value:
            servos[pin], last[0] = value, run.kernel.now_s

    def heard(color):  # the program tells the joystick's lamp whether it is on
        run.recorder.signal(run.kernel.now_s, "is_off", color["green"] < 255)

    UDPComms.moved, UDPComms.heard = moved, heard

    def dog():
        sys.modules.pop("run_robot", None)  # it runs when it is imported
        importlib.import_module("run_robot")

    def watch():
        while True:
            run.recorder.signal(run.kernel.now_s, "stepping", run.kernel.now_s - last[0] < 0.1)
            run.kernel.sleep(0.05)

    def person():
        run.recorder.signal(0.0, "is_off", True)
        run.kernel.sleep(0.5)
        for action in run.actions():
            verb, _, what = action.command.partition(" ")
            if verb == "press":
                bus.publish(Pressed(what))
                UDPComms.message[what.title()] = UDPComms.message[what] = 1
                run.kernel.sleep(0.2)
                UDPComms.message[what.title()] = UDPComms.message[what] = 0
            elif verb == "stick":
                UDPComms.message["ly"] = 1.0 if what == "ahead" else 0.0
            else:
                UDPComms.message = {} if what == "lost" else {**idle, "message_rate": 20}
            run.kernel.sleep(action.parameters["for_s"])
        run.kernel.stop("the person has left")

    for name, body in (("dog", run.measured(dog)), ("watch", watch), ("person", person)):
        run.kernel.spawn(name, body)
    return Outcome(run.go(limit_s=120.0))
