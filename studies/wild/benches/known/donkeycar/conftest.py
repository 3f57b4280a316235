import json
import sys
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import MagicMock

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Testbench, Uniform, VirtualTime

HERE = Path(__file__).parent
sys.modules.update(dict.fromkeys(("pyfiglet", "progress", "progress.bar", "prettytable", "pkg_resources"), MagicMock()))
SENT = {"half": {"throttle": 0.5}, "zero": {"throttle": 0.0}, "record": {"recording": True}, "pause": {"recording": False},
        "pilot": {"drive_mode": "local"}}


def pytest_hricdv_testbench(config):
    commands = (*(f"send {what}" for what in SENT), "close_page", "open_page")
    return Testbench(
        name="donkeycar",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(start=("one_drive", "two_drives"), groups={"manner": ("records", "drives_first", "reloads")}),
        concretization=Concretization(commands={name: {"for_s": Uniform(0.3, 3.0, "s")} for name in commands}),
        requirements=HERE / "requirements.toml",
        messages=(),
        signals={"records": bool, "asked": bool, "throttle": float},
        code=("donkeycar.vehicle", "donkeycar.memory", "donkeycar.parts.web_controller"),
        time=VirtualTime(apis=("time", "threading"), allowed_endings=("early",)),
        run=run,
    )


def run(run):
    from donkeycar.parts.web_controller.web import LocalWebController, WebSocketDriveAPI
    from donkeycar.vehicle import Vehicle

    def record(**signals):
        for name, value in signals.items():
            run.recorder.signal(run.kernel.now_s, name, value)

    page = LocalWebController()
    page.update = lambda: None  # the web server; the person below is the browser

    class Tub:
        run = lambda self, recording, throttle: record(records=bool(recording), throttle=float(throttle))
        shutdown = lambda self: None

    def car():  # as its template complete.py puts it together
        vehicle = Vehicle()
        vehicle.add(page, inputs=["cam/image_array", "tub/num_records", "user/mode", "recording"],
                    outputs=["user/angle", "user/throttle", "user/mode", "recording"], threaded=True)
        vehicle.add(Tub(), inputs=["recording", "user/throttle"])
        vehicle.start(rate_hz=20)

    def person():
        record(records=False, asked=False, throttle=0.0)
        socket = SimpleNamespace(application=page)
        WebSocketDriveAPI.open(socket)
        for action in run.actions():
            verb, _, what = action.command.partition(" ")
            if verb == "send":
                WebSocketDriveAPI.on_message(socket, json.dumps(SENT[what]))
                if "recording" in SENT[what]:
                    record(asked=SENT[what]["recording"])
            elif verb == "close_page":
                WebSocketDriveAPI.on_close(socket)
            else:
                WebSocketDriveAPI.open(socket)
            run.kernel.sleep(action.parameters["for_s"])
        run.kernel.stop("the person has left")

    run.kernel.spawn("car", run.measured(car))
    run.kernel.spawn("person", person)
    return Outcome(run.go(limit_s=120.0))
