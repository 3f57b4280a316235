import sys
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import MagicMock

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Testbench, Uniform, VirtualTime

HERE = Path(__file__).parent
sys.modules.update(dict.fromkeys(("pyfiglet", "progress", "progress.bar", "prettytable", "pkg_resources"), MagicMock()))


def pytest_hricdv_testbench(config):
    lasts, edge = {"for_s": Uniform(0.3, 2.0, "s")}, Uniform(0.95, 1.01)  # what a trained model predicts for a hard turn
    return Testbench(
        name="donkeycar_wheels",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(start=("one_lap", "two_laps"), groups={"road": ("winds", "turns_right", "turns_left", "is_straight")}),
        concretization=Concretization(commands={
            "predict soft": {"size": Uniform(-0.5, 0.5), **lasts}, "predict right": {"size": edge, **lasts},
            "predict left": {"size": edge, **lasts}, "predict full": {"size": edge, **lasts}}),
        requirements=HERE / "requirements.toml",
        messages=(),
        signals={"drives": bool, "updated_s": float, "now_s": float, "left": float, "right": float},
        code=("donkeycar.vehicle", "donkeycar.memory", "donkeycar.parts.actuator"),
        time=VirtualTime(apis=("time", "threading"), allowed_endings=("early",)),
        run=run,
    )


def run(run):
    from donkeycar.parts.actuator import L298N_HBridge_2pin, TwoWheelSteeringThrottle
    from donkeycar.vehicle import Vehicle

    asked = [0.0, 0.0]  # throttle and angle

    def record(**signals):
        for name, value in signals.items():
            run.recorder.signal(run.kernel.now_s, name, value)

    def motor(side):
        duty = lambda value: record(**{side: float(value), "updated_s": run.kernel.now_s})
        forward = SimpleNamespace(start=duty, stop=lambda: duty(0), duty_cycle=duty)
        return L298N_HBridge_2pin(forward, SimpleNamespace(start=duty, stop=lambda: None, duty_cycle=lambda value: None))

    class Pilot:
        run = lambda self: tuple(asked)
        shutdown = lambda self: None

    def car():  # as its template complete.py puts it together, for DC_TWO_WHEEL
        vehicle = Vehicle()
        vehicle.add(Pilot(), outputs=["throttle", "angle"])
        vehicle.add(TwoWheelSteeringThrottle(), inputs=["throttle", "angle"], outputs=["left_motor_speed", "right_motor_speed"])
        for side in ("left", "right"):
            vehicle.add(motor(side), inputs=[f"{side}_motor_speed"])
        vehicle.start(rate_hz=20)

    def road():
        record(drives=False, updated_s=0.0, now_s=0.0, left=0.0, right=0.0)
        run.kernel.sleep(0.5)
        record(drives=True)
        for action in run.actions():
            size, what = action.parameters["size"], action.command.partition(" ")[2]
            asked[:] = {"soft": (0.5, size), "right": (0.5, size), "left": (0.5, -size), "full": (size, 0.0)}[what]
            for _ in range(int(action.parameters["for_s"] * 10)):
                run.kernel.sleep(0.1)
                record(now_s=run.kernel.now_s)
        record(drives=False)
        run.kernel.stop("the lap is over")

    run.kernel.spawn("car", run.measured(car))
    run.kernel.spawn("road", road)
    return Outcome(run.go(limit_s=120.0))
