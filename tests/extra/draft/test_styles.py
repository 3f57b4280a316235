"""Servers and callbacks of libraries, arguments of unknown type, and queues, as drafts have them."""

from __future__ import annotations

import asyncio
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from pytest_hricdv.draft import unknown
from pytest_hricdv.extra.draft.code_model import CodeModel
from pytest_hricdv.extra.draft.draft_analysis import CodeReader
from pytest_hricdv.extra.draft.first_runs import _last_command
from pytest_hricdv.extra.draft.project.draft import Draft
from pytest_hricdv.extra.draft.project.files import files
from pytest_hricdv.extra.draft.stand_ins.border import RunBorder
from pytest_hricdv.extra.draft.stand_ins.channels import AsyncInbox, Inbox
from pytest_hricdv.extra.draft.stand_ins.connections import ServerStandIn, StreamStandIn, TextStandIn
from pytest_hricdv.extra.draft.stand_ins.parts import Device, cross_border


def read(folder: Path, source: str) -> CodeModel:
    (folder / "robot_code.py").write_text(source, encoding="utf-8")
    return CodeReader("robot_code", folder).model()


def fields(model: CodeModel) -> dict[str, dict[str, list[str]]]:
    """Topic of each message that is received -> its fields, with their texts."""
    return {message.topic: {part.name: [value.text for value in part.values] for part in message.fields}
            for message in model.inputs}  # fmt: skip


SERVER = """
import asyncio, json
import websockets

ROBOT = {"motors": None}

async def control(websocket):
    async for text in websocket:
        obey(text)

def obey(text):
    command = json.loads(text)
    match command["kind"].upper():
        case "DRIVE":
            ROBOT["motors"].set(float(command["left"]), float(command.get("right", 0.0)))
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
    made = "json.dumps({'kind': m.kind, 'left': m.left, 'right': m.right})"
    assert f'Replace("{target}", ConnectionPort("serve", kinds={{WebsocketItem: lambda m: {made}}}))' in conftest


@pytest.mark.parametrize(
    ("kind", "content", "method"), [(StreamStandIn, b"tea\n", "write"), (TextStandIn, "tea", "send")]
)
def test_a_server_has_one_client_and_raises_what_it_raises(
    kind: type[StreamStandIn], content: object, method: str
) -> None:
    told: list[object] = []
    heard: list[object] = []

    async def client(connection: Any, other: object) -> None:
        heard.append(await connection.readline())
        said = getattr(connection, method)(b"ready")
        if said is not None:
            await said
        assert not connection.closed()
        raise EOFError

    class OneText:
        async def get(self) -> str:
            return "tea"

    async def serve() -> None:
        border: Any = SimpleNamespace(
            note_call=lambda *_: None, tell_call=lambda port, name, given, _: told.append((port, name, given))
        )
        inbox: Any = OneText()
        async with ServerStandIn(client, lambda: kind(border, "server", inbox)) as server:
            await server.serve_forever()

    with pytest.raises(EOFError):
        asyncio.run(serve())
    assert (heard, told) == ([content], [("server", method, (b"ready",))])


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
    border: Any = SimpleNamespace(unknown={}, senses={}, answers={}, inboxes={}, devices=set(), pass_time=lambda: None,
                                  note_use=lambda path, other, _: noted.append((path, other)))  # fmt: skip
    with cross_border(border):
        assert unknown("on_person.detection") is unknown("on_person.detection")  # one in each run
        assert unknown("on_person.detection")["distance"] < 1.5
        border.senses["on_person.detection[distance]"] = 2.0
        border.on_crossing, border.read_sense = lambda: None, border.senses.get
        assert unknown("on_person.detection")["distance"] > 1.5
    assert noted[0] == ("on_person.detection[distance]", 1.5)


def test_a_device_may_have_a_method_of_any_name() -> None:
    calls: list[object] = []
    border: Any = RunBorder(SimpleNamespace(), frozenset(), {}, {})  # type: ignore[arg-type]
    border.note_call = lambda *call: calls.append(call[:2])
    phone = Device().make(border, "phone")
    with cross_border(border):
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


LAMP = """
class Lamp:
    def __init__(self, bulb):
        self.bulb = bulb
    def update(self):
        self.bulb.shine()

class Hall:
    def __init__(self, bulb):
        self.lamp = Lamp(bulb)
    def on_request(self, request):
        if request.method == "POST" and request.data.get("lamp"):
            self.update()
    def update(self):
        self.lamp.update()
"""


def test_a_method_that_another_class_calls_by_the_same_name_is_still_called_from_outside(tmp_path: Path) -> None:
    source = LAMP.replace("self.update()", "self.lamp.update()").replace("self.bulb.shine()", "self.update")
    assert [message.topic for message in read(tmp_path, source).inputs] == ["on_request", "update"]


def test_an_object_of_which_attributes_are_known_has_all_others_too(tmp_path: Path) -> None:
    (on_request,) = read(tmp_path, LAMP).inputs
    assert on_request.delivery == "MethodCall('on_request', lambda m: (Neutral(method=m.method),))"


def test_the_module_that_was_asked_for_has_the_entry(tmp_path: Path) -> None:
    (tmp_path / "lamps.py").write_text(LAMP, encoding="utf-8")
    program = "from lamps import Hall\n\ndef main():\n    Hall(None)\n\nif __name__ == '__main__':\n    main()\n"
    (tmp_path / "program.py").write_text(program, encoding="utf-8")
    entries = [CodeReader(asked, tmp_path).model().entry for asked in ("program.py", "lamps.py")]
    assert [entry and entry.name for entry in entries] == ["main", "Hall"]


def test_a_command_is_left_out_by_the_message_at_which_the_code_raised() -> None:
    test = {
        "abstract": ["wake in_time", "wait_answer", "sleep_bed in_time", "wait_quiet"],
        "action_times_s": [0.2, 1.0, 2.0, 3.0],
        "failure": "node robot hears wake raised ValueError: awake at 33.0 s",
    }
    assert _last_command(test) == "wake"
    assert _last_command({**test, "failure": "ValueError: no bed"}) == "sleep_bed"
