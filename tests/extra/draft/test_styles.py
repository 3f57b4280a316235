"""Messages and states of code in other styles: a dispatcher, `match`, JSON of a class, a server of a library."""

from __future__ import annotations

import asyncio
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from pytest_hricdv.draft import unknown
from pytest_hricdv.extra.draft.code_model import CodeModel
from pytest_hricdv.extra.draft.draft_analysis import CodeReader
from pytest_hricdv.extra.draft.first_runs import sentence_of
from pytest_hricdv.extra.draft.project.draft import Draft
from pytest_hricdv.extra.draft.project.files import files
from pytest_hricdv.extra.draft.stand_ins.absent import cross_border
from pytest_hricdv.extra.draft.stand_ins.channels import AsyncInbox, Inbox
from pytest_hricdv.extra.draft.stand_ins.connections import ServerStandIn, TextStandIn
from pytest_hricdv.extra.draft.stand_ins.device import Device


def read(folder: Path, source: str) -> CodeModel:
    (folder / "robot_code.py").write_text(source, encoding="utf-8")
    return CodeReader("robot_code", folder).model()


def fields(model: CodeModel) -> dict[str, dict[str, list[str]]]:
    """Topic of each message that is received -> its fields, with their texts."""
    return {message.topic: {part.name: [value.text for value in part.values] for part in message.fields}
            for message in model.inputs}  # fmt: skip


DISPATCHER = """
import queue, threading

class Dispatcher(threading.Thread):
    def __init__(self, inbox):
        super().__init__()
        self.inbox, self.handlers = inbox, {}
    def register(self, name, handler):
        self.handlers[name] = handler
    def run(self):
        while True:
            name, payload = self.inbox.get()
            self.handlers[name](payload)

class Fetcher:
    def __init__(self, arm):
        self.arm, self.inbox = arm, queue.Queue()
        self.dispatcher = Dispatcher(self.inbox)
        self.dispatcher.register("fetch", self._on_fetch)
    def start(self):
        self.dispatcher.start()
    def _on_fetch(self, payload):
        if payload["tool"] == "pliers" and self.arm.is_free():
            self.arm.move(payload["tool"])

def main():
    Fetcher(object()).start()

if __name__ == "__main__":
    main()
"""


def test_the_robot_is_what_the_main_program_makes_and_not_a_part_of_it(tmp_path: Path) -> None:
    model = read(tmp_path, DISPATCHER)
    assert model.entry is not None
    assert model.entry.name == "Fetcher"
    assert fields(model) == {"fetch": {"tool": ["pliers"]}}


MATCH = """
from dataclasses import dataclass
from enum import Enum
from typing import Annotated, Union

@dataclass
class Grip:
    left: bool

@dataclass
class Seen:
    distance_m: float
    kind: str
    side: str

Event = Annotated[Union[Grip, Seen], "by its class"]

class Mode(Enum):
    LOCKED = 1
    WALKING = 2

class Walker:
    def __init__(self):
        self._mode = Mode.LOCKED
    def feed(self, event: Event):
        self._handle(event)
    def _handle(self, event: Event):
        match (self._mode, event):
            case (Mode.LOCKED, Grip(left=True)):
                self._mode = Mode.WALKING
            case (Mode.WALKING, Seen(side="left", kind=kind)):
                self._mode = Mode.LOCKED if kind == "person" else Mode.WALKING
"""


def test_patterns_of_classes_have_the_messages_and_their_texts(tmp_path: Path) -> None:
    model = read(tmp_path, MATCH)
    expected = {"grip": {"left": []}, "seen": {"distance_m": [], "kind": ["person"], "side": ["left"]}}
    assert fields(model) == expected
    assert model.machine is not None
    assert [state.name for state in model.machine.states] == ["LOCKED", "WALKING"]


SOCKET = """
import asyncio, json

class Rover:
    def __init__(self, motors):
        self.motors, self.mode = motors, "parked"
    async def handler(self, websocket):
        async for raw in websocket:
            await self.on_message(websocket, json.loads(raw))
    async def on_message(self, websocket, message):
        action = message.get("action")
        if action == "drive":
            self.motors.set(float(message["x"]))
            await self.change("driving")
        elif action == "stop":
            self.motors.stop()
            await self.change("parked")
    async def change(self, mode):
        if mode != self.mode:
            self.mode = mode
    async def watch(self):
        while True:
            await asyncio.sleep(0.1)
"""


def test_handlers_tell_kinds_apart_and_get_more_than_the_code_says_itself(tmp_path: Path) -> None:
    model = read(tmp_path, SOCKET)
    assert fields(model) == {"drive": {"x": []}, "stop": {}}  # and no `change`
    deliveries = {message.topic: message.delivery for message in model.inputs}
    made = "MethodCall('on_message', lambda m: (unknown('on_message.websocket'), {'action': 'drive', 'x': m.x},))"
    assert deliveries["drive"] == made


LISTENER = """
import time

class Patrol:
    def __init__(self, tree, speaker):
        self.speaker, self.answer = speaker, ""
        tree.add_post_tick_handler(self._on_tick)
    def _on_tick(self, tree):
        self.speaker.say(self.answer)
    def on_speech(self, text):
        words = text.lower().split()
        if "help" in words:
            self.answer = "help"
        elif "fine" in words:
            self.answer = ""
    def spin(self):
        while True:
            time.sleep(1.0)
"""


def test_a_callback_without_content_leaves_the_methods_and_words_of_a_text_are_its_values(tmp_path: Path) -> None:
    assert fields(read(tmp_path, LISTENER))["on_speech"] == {"text": ["help", "fine"]}


READERS = (
    "order = Order(**json.loads(message.payload))",
    "order = decode(Order, message.payload)",
    "order = Order.model_validate_json(message.payload)",
    "content = json.loads(message.payload.decode())\n        order = Order.from_dict(content)",
)


@pytest.mark.parametrize("line", READERS)
def test_json_of_a_class_has_its_fields(line: str, tmp_path: Path) -> None:
    source = f"""
import json
from dataclasses import dataclass, field

@dataclass
class Order:
    drink: str
    sugar: int
    extras: list = field(default_factory=list)

def decode(kind, payload):
    return kind(**json.loads(payload))

class Barista:
    def __init__(self, client, mill):
        self.mill = mill
        client.message_callback_add("cafe/order", self._on_order)
    def _on_order(self, client, userdata, message):
        {line}
        if order.drink in ("lungo", "mocha") and order.sugar < 3:
            self.mill.start()
"""
    model = read(tmp_path, source)
    assert fields(model) == {"order": {"drink": ["lungo", "mocha"], "sugar": []}}
    (order,) = model.inputs
    made = "SimpleNamespace(topic='', payload=json.dumps({'drink': m.drink, 'sugar': m.sugar}).encode())"
    assert made in order.delivery


def test_a_machine_that_a_function_makes_for_an_object_is_its_state(tmp_path: Path) -> None:
    source = """
from transitions import Machine

def attach(model):
    return Machine(model=model, states=["idle", "pouring"], initial="idle",
                   transitions=[{"trigger": "pour", "source": "idle", "dest": "pouring"}])

class Barista:
    def __init__(self, bell):
        self.machine = attach(self)
        bell.on_ring(self._ring)
    def _ring(self, table):
        if table == "left":
            self.pour()
"""
    model = read(tmp_path, source)
    assert model.state == "state_changed.state"
    assert next(message.channel for message in model.messages if message.form == "state") == "state"


SERVER = """
import asyncio, json
import websockets

ROBOT = {"motors": None}

async def control(websocket):
    async for text in websocket:
        obey(text)

def obey(text):
    command = json.loads(text)
    wheels = command["data"]["wheels"]
    match command["data"]["kind"].upper():
        case "DRIVE":
            ROBOT["motors"].set(float(wheels["left"]), float(wheels.get("right", 0.0)))
        case "BRAKE":
            ROBOT["motors"].set(0.0, 0.0)

BEGIN
"""

MAIN = """
async def main():
    async with websockets.serve(control, "", 8001):
        await asyncio.Future()

if __name__ == "__main__":
    asyncio.run(main())
"""

BARE = """
asyncio.ensure_future(websockets.serve(control, "", 8001))
asyncio.get_event_loop().run_forever()
"""


@pytest.mark.parametrize(("begin", "target"), [(MAIN, "robot_code:websockets.serve"), (BARE, "websockets:serve")])
def test_a_library_that_serves_connections_has_a_person_at_the_other_end(
    begin: str, target: str, tmp_path: Path
) -> None:
    model = read(tmp_path, SERVER.replace("BEGIN", begin))
    assert fields(model) == {"websocket_item": {"kind": ["DRIVE", "BRAKE"], "left": [], "right": []}}
    conftest = dict(files(Draft(model, "robot_code", "person", tmp_path.resolve() / "hri")))["conftest.py"]
    made = "json.dumps({'data': {'kind': m.kind, 'wheels': {'left': m.left, 'right': m.right}}})"
    assert f'Replace("{target}", ConnectionPort("serve", kinds={{WebsocketItem: lambda m: {made}}}))' in conftest


def test_a_server_of_a_library_gives_texts_to_its_only_client() -> None:
    told: list[object] = []

    async def client(websocket: Any, path: str) -> None:
        async for text in websocket:
            await websocket.send(text)
            assert not websocket.closed()
            raise EOFError

    class OneText:
        async def get(self) -> str:
            return "tea"

    async def serve() -> None:
        border: Any = SimpleNamespace(note_call=lambda *_: None, tell_call=lambda *call: told.append(call))
        inbox: Any = OneText()
        server = await ServerStandIn(client, lambda: TextStandIn(border, "server", inbox))
        await server.serve_forever()

    with pytest.raises(EOFError):
        asyncio.run(serve())
    assert told == [("server", "send", ("tea",), {})]


HANDED = """
import paho.mqtt.client as mqtt

TOPICS = {"stop": "robot/stop", "go": "robot/go"}

def on_message(client, userdata, message):
    if message.topic == TOPICS["stop"]:
        print("stop")
    elif message.topic == TOPICS["go"]:
        print("go")

client = mqtt.Client()
client.on_message = on_message
client.loop_forever()
"""


def test_functions_that_a_program_hands_to_a_library_are_what_people_do(tmp_path: Path) -> None:
    model = read(tmp_path, HANDED)
    assert fields(model) == {"on_message": {"topic": ["robot/stop", "robot/go"]}}
    assert model.inputs[0].delivery.startswith("MethodCall('robot_code:on_message', ")


QUEUE = """
import queue, threading

class Arm:
    def __init__(self, motor):
        self.motor, self.words = motor, queue.Queue()
    def run(self):
        while True:
            word = self.words.get()
            if word == "up":
                self.motor.rise()
            elif word == "down":
                self.motor.sink()
"""


def test_plain_texts_in_a_queue_are_messages(tmp_path: Path) -> None:
    source = QUEUE.replace("motor):", "motor, words):").replace("queue.Queue()", "words")
    assert fields(read(tmp_path, source)) == {"words_item": {"word": ["up", "down"]}}


def test_what_the_code_compares_of_an_argument_is_observed_and_set_by_a_person(tmp_path: Path) -> None:
    source = """
class Patrol:
    def __init__(self, board, speaker):
        self.board, self.speaker = board, speaker
    def on_person(self, detection):
        self.board.person = detection
    def on_speech(self, text):
        if text == "help":
            self.speaker.say("I call somebody")
"""
    (on_person, _) = read(tmp_path, source).inputs
    assert on_person.delivery == "MethodCall('on_person', lambda m: (unknown('on_person.detection'),))"
    noted: list[object] = []
    border: Any = SimpleNamespace(unknown={}, senses={}, pass_time=lambda: None,
                                  note_absent_use=lambda path, other, _: noted.append((path, other)))  # fmt: skip
    with cross_border(border):
        assert unknown("on_person.detection") is unknown("on_person.detection")  # one in each run
        assert unknown("on_person.detection")["distance"] < 1.5
        border.senses["on_person.detection[distance]"] = 2.0
        border.on_crossing, border.read_sense = lambda: None, border.senses.get
        assert unknown("on_person.detection")["distance"] > 1.5
    assert noted[0] == ("on_person.detection[distance]", 1.5)


def test_a_device_may_have_a_method_of_any_name() -> None:
    calls: list[object] = []
    border: Any = SimpleNamespace(note_call=lambda *call: calls.append(call[:2]), pass_time=lambda: None,
                                  tell_call=lambda *_: None, answer=lambda *_: None, is_async=False)  # fmt: skip
    phone = Device().make(border, "phone")
    phone.call("nurse")
    assert calls == [("phone", "call")]


def test_queues_have_each_method() -> None:
    border: Any = SimpleNamespace(run=SimpleNamespace(kernel=None))
    inbox: Any = Inbox(border, {})
    inbox.put("of the code itself")
    assert inbox.task_done() == 0
    assert not inbox.full()
    with pytest.raises(AttributeError):
        _ = inbox.__deepcopy__

    async def look() -> None:
        other: Any = AsyncInbox(border, {})
        await other.put("of the code itself")
        assert other.empty()

    asyncio.run(look())


def test_a_failure_without_a_traceback_is_told_by_its_first_line() -> None:
    assert sentence_of("StateChanged.state: 'lost' is none of its values\n\nended:   after 3 s") == (
        "StateChanged.state: 'lost' is none of its values"
    )
