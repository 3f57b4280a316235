import json
import sys
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import MagicMock

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Testbench, Uniform, VirtualTime

HERE = Path(__file__).parent
sys.modules.update(dict.fromkeys(("pyfiglet", "progress", "progress.bar"), MagicMock()))
SENT = {"half": '{"throttle": 0.5}', "zero": '{"throttle": 0.0}', "much": '{"throttle": 3.0}', "null": '{"throttle": null}',
        "left": '{"angle": -1.0}', "broken": '{"throttle": 0.', "pilot": '{"drive_mode": "local"}'}


def pytest_hricdv_testbench(config):
    commands = (*(f"send {what}" for what in SENT), "close_page", "open_page")
    return Testbench(
        name="donkeycar",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(start=("one_drive", "two_drives"),
                            groups={"manner": ("leaves", "fast", "odd", "cut_off", "reloads")}),
        concretization=Concretization(commands={name: {"for_s": Uniform(0.3, 3.0, "s")} for name in commands}),
        requirements=HERE / "requirements.toml",
        messages=(),
        signals={"throttle": float, "is_open": bool, "ticks": float, "asked_zero": bool},
        code=("donkeycar.vehicle", "donkeycar.memory", "donkeycar.parts.web_controller"),
        time=VirtualTime(apis=("time", "threading"), allowed_endings=("early",)),
        run=run,
    )


def run(run):
    from donkeycar.vehicle import Vehicle
    from donkeycar.parts.web_controller.web import LocalWebController, WebSocketDriveAPI

    def record(**signals):
        for name, value in signals.items():
            run.recorder.signal(run.kernel.now_s, name, value)

    page = LocalWebController()
    page.update = lambda: None  # the web server; the person below is the browser

    class Motor:
        def run(self, angle, throttle):
            record(throttle=float(throttle), ticks=run.kernel.now_s)

        def shutdown(self):
            record(throttle=0.0)

    def car():
        vehicle = Vehicle()
        vehicle.add(page, outputs=["angle", "throttle", "mode", "recording", "buttons"], threaded=True)
        vehicle.add(Motor(), inputs=["angle", "throttle"])
        vehicle.start(rate_hz=20)

    def person():
        record(throttle=0.0, is_open=True, ticks=0.0, asked_zero=True)
        socket = SimpleNamespace(application=page)
        WebSocketDriveAPI.open(socket)
        for action in run.actions():
            verb, _, what = action.command.partition(" ")
            if verb == "send":
                try:
                    WebSocketDriveAPI.on_message(socket, SENT[what])
                except json.JSONDecodeError:  # the server logs it, and closes the connection
                    verb = "close_page"
            if verb == "close_page" and page.wsclients:
                WebSocketDriveAPI.on_close(socket)
            elif verb == "open_page":
                WebSocketDriveAPI.open(socket)
            record(is_open=bool(page.wsclients), asked_zero=what == "zero")
            run.kernel.sleep(action.parameters["for_s"])
        run.kernel.stop("the person has left")

    run.kernel.spawn("car", run.measured(car))
    run.kernel.spawn("person", person)
    return Outcome(run.go(limit_s=120.0))
