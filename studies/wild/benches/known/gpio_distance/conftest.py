import sys
from pathlib import Path
from unittest.mock import MagicMock

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Testbench, Uniform, VirtualTime

HERE = Path(__file__).parent
sys.modules["pkg_resources"] = MagicMock()  # it is not installed
SPEED_OF_SOUND, NEAR_M, FAR_M = 343.26, 0.2, 0.9


def pytest_hricdv_testbench(config):
    stays, misses = {"for_s": Uniform(0.5, 3.0, "s")}, {"edges": Uniform(1.0, 4.0), "for_s": Uniform(0.5, 2.0, "s")}
    return Testbench(
        name="gpio_distance",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(start=("one_walk", "two_walks"), groups={"then": ("rise_lost", "fall_lost", "both_lost", "leaves")}),
        concretization=Concretization(commands={"stand": stays, "step_off": stays, "lose rise": misses, "lose fall": misses}),
        requirements=HERE / "requirements.toml",
        messages=(),
        signals={"near": bool, "distance": float},
        code=("gpiozero.input_devices", "gpiozero.mixins"),
        time=VirtualTime(apis=("time", "threading"), allowed_endings=("early",)),
        run=run,
    )


def run(run):
    from gpiozero import Device, DistanceSensor
    from gpiozero.pins.mock import MockFactory, MockPin

    place, lost = [FAR_M], {"rise": 0, "fall": 0}

    def record(**signals):
        for name, value in signals.items():
            run.recorder.signal(run.kernel.now_s, name, value)

    def edge(name, drive):  # RPi.GPIO can miss an edge
        lost[name] -= 1
        echo_pin.edges = "none" if lost[name] >= 0 else "both"
        drive()
        echo_pin.edges = "both"

    def echo():
        run.kernel.sleep(0.0005)
        edge("rise", echo_pin.drive_high)
        run.kernel.sleep(2 * place[0] / SPEED_OF_SOUND)
        edge("fall", echo_pin.drive_low)

    class Trigger(MockPin):
        def _set_state(self, value):
            super()._set_state(value)
            if value:
                run.kernel.spawn("echo", echo)

    Device.pin_factory, DistanceSensor.ECHO_LOCK = MockFactory(), type(DistanceSensor.ECHO_LOCK)()
    Device.pin_factory.reset()  # both are kept by the class, from run to run
    echo_pin = Device.pin_factory.pin(4)
    Device.pin_factory.pin(5, pin_class=Trigger)

    def program():
        record(near=False, distance=1.0)
        sensor = DistanceSensor(4, 5, queue_len=3, partial=True)
        run.kernel.sleep(0.5)  # without a value, it has no distance
        while True:
            run.kernel.sleep(0.1)
            record(distance=sensor.distance)

    def person():
        run.kernel.sleep(1.0)
        for action in run.actions():
            verb, _, which = action.command.partition(" ")
            if verb == "lose":
                lost[which] = int(action.parameters["edges"])
            else:
                place[0] = NEAR_M if verb == "stand" else FAR_M
                record(near=verb == "stand")
            run.kernel.sleep(action.parameters["for_s"])
        run.kernel.stop("the person has left")

    run.kernel.spawn("program", run.measured(program))
    run.kernel.spawn("person", person)
    return Outcome(run.go(limit_s=60.0))
