import sys
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import MagicMock

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Testbench, Uniform, VirtualTime

HERE = Path(__file__).parent
sys.modules.update(dict.fromkeys(("libusb_package", "usb", "usb.core"), MagicMock()))


@dataclass(frozen=True)
class Landed:
    """The call has returned."""


def pytest_hricdv_testbench(config):
    length = {"m": Uniform(0.1, 0.5, "m")}
    stay = {"for_s": Uniform(0.1, 2.0, "s")}
    return Testbench(
        name="motion_commander",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(start=("one_flight", "two_flights"),
                            groups={"flight": ("box", "low", "still", "drift")}),
        concretization=Concretization(
            commands={"take_off": {}, "land": {}, "forward": length, "left": length, "down": {"m": Uniform(0.3, 0.3, "m")},
                      "start_forward": {}, "stay": stay},
        ),
        requirements=HERE / "requirements.toml",
        messages=(Landed,),
        signals={"motors_on": bool, "is_locked": bool},
        code=("cflib.positioning.motion_commander",),
        time=VirtualTime(apis=("time", "threading"), allowed_endings=("early",)),
        run=run,
    )


def run(run):
    from cflib.positioning.motion_commander import MotionCommander

    bus, due_s = run.bus.port("drone"), [None]  # until when a setpoint has to come; None: its high-level commander makes them

    def record(**signals):
        for name, value in signals.items():
            run.recorder.signal(run.kernel.now_s, name, value)

    def setpoint(motors_on):
        due_s[0] = run.kernel.now_s + 2.0
        record(motors_on=motors_on)

    def supervisor():  # of the firmware
        while True:
            run.kernel.sleep(0.1)
            if due_s[0] is not None and run.kernel.now_s > due_s[0]:
                record(is_locked=True)

    commander = SimpleNamespace(send_hover_setpoint=lambda vx, vy, yaw_rate, z: setpoint(True),
                                send_stop_setpoint=lambda: setpoint(False),
                                send_notify_setpoint_stop=lambda *arguments: due_s.__setitem__(0, None))
    drone = SimpleNamespace(is_connected=lambda: True, commander=commander,
                            param=SimpleNamespace(set_value=lambda name, value: None))
    record(motors_on=False, is_locked=False)

    def program():
        flight = MotionCommander(drone)
        for action in run.actions():
            if action.command == "stay":
                run.kernel.sleep(action.parameters["for_s"])
            elif action.command == "land":
                flight.land()
                bus.publish(Landed())
            else:
                getattr(flight, action.command)(*action.parameters.values())
        run.kernel.sleep(4.0)
        run.kernel.stop("the program has ended")

    run.kernel.spawn("supervisor", supervisor)
    run.kernel.spawn("program", run.measured(program))
    return Outcome(run.go(limit_s=200.0))
