import sys
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import MagicMock

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Testbench, Uniform, VirtualTime

HERE = Path(__file__).parent
sys.modules["av"] = MagicMock()


@dataclass(frozen=True)
class Moves:
    is_asked: bool


@dataclass(frozen=True)
class Packet:
    is_answer: bool


def pytest_hricdv_testbench(config):
    return Testbench(
        name="tello",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(start=("one_flight", "two_flights"), groups={"link_is": ("fine", "lossy", "sluggish", "noisy")}),
        concretization=Concretization(commands={
            **{f"link {name}": {} for name in ("good", "loses", "slow", "garbled")}, "takeoff": {}, "land": {}, "move_forward": {}, "rotate_clockwise": {},
            "height": {"after_s": Uniform(0.5, 3.0, "s")}, "stay": {"after_s": Uniform(0.01, 3.0, "s")}}),
        requirements=HERE / "requirements.toml",
        messages=(Moves, Packet),
        signals={"age_s": float},
        code=("djitellopy.tello",),
        time=VirtualTime(apis=("time", "threading"), allowed_endings=("early",)),
        run=run,
    )


def run(run):
    from djitellopy import Tello, tello

    bus, link, asked, done = run.bus.port("drone"), ["good"], [0], []
    inboxes = {8889: [], 8890: []}

    class Udp:
        def bind(self, address):
            self.inbox = inboxes[address[1]]

        def recvfrom(self, size):
            while not self.inbox:
                run.kernel.sleep(0.01)
            return self.inbox.pop(0), (Tello.TELLO_IP, 8889)

        def sendto(self, data, address):
            bus.publish(Packet(False))
            if data.partition(b" ")[0] in (b"forward", b"cw", b"takeoff", b"land"):
                done.append(data)
                bus.publish(Moves(len(done) <= asked[0]))
            run.kernel.spawn("drone", answer)

    def answer():
        run.kernel.sleep(8.0 if link[0] == "slow" else 0.35)
        if link[0] != "loses":
            inboxes[8889].append(b"ok")
            bus.publish(Packet(True))

    tello.socket = SimpleNamespace(socket=lambda *kind: Udp(), AF_INET=2, SOCK_DGRAM=2)
    tello.threads_initialized = False

    def states():
        while True:
            inboxes[8890].append(b"\xff\xfe" if link[0] == "garbled" else f"h:{int(run.kernel.now_s)};bat:80;".encode())
            run.kernel.sleep(0.1)

    def program():
        run.recorder.signal(0.0, "age_s", 0.0)
        drone = Tello()
        drone.connect()
        for action in run.actions():
            verb, _, what = action.command.partition(" ")
            run.kernel.sleep(action.parameters.get("after_s", 0.0))
            link[0] = what or link[0]
            if verb == "height":
                run.recorder.signal(run.kernel.now_s, "age_s", run.kernel.now_s - drone.get_height())
            elif verb not in ("stay", "link"):
                asked[0] += 1
                with suppress(tello.TelloException):
                    getattr(drone, verb)(*[50] * (verb in ("move_forward", "rotate_clockwise")))
                asked[0] = len(done)
        run.kernel.stop("the program has ended")

    run.kernel.spawn("states", states)
    run.kernel.spawn("program", run.measured(program))
    return Outcome(run.go(limit_s=400.0))
