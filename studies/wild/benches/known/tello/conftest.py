import sys
from dataclasses import make_dataclass
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import MagicMock

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Testbench, Uniform, VirtualTime

HERE = Path(__file__).parent
sys.modules.update(dict.fromkeys(("av", "cv2"), MagicMock()))
VERBS = {"emergency": "emergency", "end": "end", "state": "get_battery", "takeoff": "takeoff", "throw": "initiate_throw_takeoff"}


Asked, Done, Told = (make_dataclass(name, [("what", str)], frozen=True) for name in ("Asked", "Done", "Told"))


def pytest_hricdv_testbench(config):
    return Testbench(
        name="tello",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(start=("starts", "is_thrown", "stays_down"), groups={"does": ("looks", "presses_stop", "crashes")}),
        concretization=Concretization(commands={**dict.fromkeys(VERBS, {}), "stay": {"for_s": Uniform(0.1, 3.0, "s")}, "crash": {}}),
        requirements=HERE / "requirements.toml",
        messages=(Asked, Done, Told),
        signals={"flies": bool},
        code=("djitellopy.tello",),
        time=VirtualTime(apis=("time", "threading"), allowed_endings=("early",)),
        run=run,
    )


def run(run):
    from djitellopy import Tello, tello

    bus, inboxes, drone_is = run.bus.port("drone"), {8889: [], 8890: []}, {"on": True}

    flies = lambda value: run.recorder.signal(run.kernel.now_s, "flies", value)

    class Udp:
        bind = lambda self, address: setattr(self, "inbox", inboxes[address[1]])

        def recvfrom(self, size):
            while not self.inbox:
                run.kernel.sleep(0.01)
            return self.inbox.pop(0), (Tello.TELLO_IP, 8889)

        def sendto(self, data, address):
            command = data.decode()
            bus.publish(Told(command))
            if command == "emergency":
                flies(False)  # and does not answer
            elif drone_is["on"]:
                run.kernel.spawn("drone", lambda: answer(command))

    def answer(command):
        run.kernel.sleep(0.35)
        inboxes[8889].append(b"ok")
        command == "command" or flies(drone_is["on"] and command != "land")

    tello.socket, tello.threads_initialized = SimpleNamespace(socket=lambda *kind: Udp(), AF_INET=2, SOCK_DGRAM=2), False

    def states():
        while True:
            run.kernel.sleep(0.5)  # so the first one comes later than the answer to the first command
            inboxes[8890] += [b"h:0;bat:80;"] * drone_is["on"]

    def program():
        flies(False)
        drone = Tello()
        drone.connect()
        for action in run.actions():
            if action.command == "stay":
                run.kernel.sleep(action.parameters["for_s"])
            elif action.command == "crash":
                drone_is["on"] = flies(False) or False
            else:
                run.kernel.sleep(0.01)
                bus.publish(Asked(action.command))
                try:
                    getattr(drone, VERBS[action.command])()
                    bus.publish(Done(action.command))
                except Exception:
                    bus.publish(Done("error"))
        run.kernel.sleep(2.0)
        drone.stream_on = drone.is_flying = False
        run.kernel.stop("the program has ended")

    run.kernel.spawn("states", states)
    run.kernel.spawn("program", run.measured(program))
    return Outcome(run.go(limit_s=400.0))
