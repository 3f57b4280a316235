from dataclasses import dataclass
from pathlib import Path

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Testbench, Uniform, VirtualTime

HERE = Path(__file__).parent


@dataclass(frozen=True)
class Read:
    has_failed: bool


def pytest_hricdv_testbench(config):
    lasts = {"for_s": Uniform(0.05, 1.5, "s")}
    return Testbench(
        name="gpio_motion",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(start=("one_visit", "two_visits"), groups={"walk": ("passes", "stays", "twitches")}),
        concretization=Concretization(commands={"move": lasts, "stand_still": lasts}),
        requirements=HERE / "requirements.toml",
        messages=(Read,),
        signals={"moves": bool, "seen": bool},
        code=("gpiozero.input_devices", "gpiozero.mixins", "gpiozero.threads"),
        time=VirtualTime(apis=("time", "threading"), allowed_endings=("early",)),
        run=run,
    )


def run(run):
    from gpiozero import Device, MotionSensor
    from gpiozero.pins.mock import MockFactory

    Device.pin_factory, bus = MockFactory(), run.bus.port("program")
    Device.pin_factory.reset()  # its pins are kept by the class, from run to run
    pin = Device.pin_factory.pin(4)

    def record(**signals):
        for name, value in signals.items():
            run.recorder.signal(run.kernel.now_s, name, value)

    def program():  # as the loop of the report: a robot that looks whether somebody moves
        record(moves=False, seen=False)
        sensor = MotionSensor(4, queue_len=5, sample_rate=20, partial=True)
        while True:
            try:
                record(seen=sensor.motion_detected)
                bus.publish(Read(False))
            except RuntimeError:
                bus.publish(Read(True))
            run.kernel.sleep(0.05)

    def person():
        run.kernel.sleep(0.5)
        for action in run.actions():
            (pin.drive_high if action.command == "move" else pin.drive_low)()
            record(moves=action.command == "move")
            run.kernel.sleep(action.parameters["for_s"])
        run.kernel.stop("the person has left")

    run.kernel.spawn("program", run.measured(program))
    run.kernel.spawn("person", person)
    return Outcome(run.go(limit_s=60.0))
