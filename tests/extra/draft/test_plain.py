"""Messages without a class: texts, dicts and tuples in queues."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
import tomllib
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from pytest_hricdv.extra.draft.analysis import analyse
from pytest_hricdv.extra.draft.found.findings import Findings, Message
from pytest_hricdv.extra.draft.writing.drafted import Draft
from pytest_hricdv.extra.draft.writing.plain_classes import CONVERTING
from pytest_hricdv.extra.draft.writing.project import files
from tests.extra.draft import plain_robots


def found(tmp_path: Path, source: str) -> Findings:
    (tmp_path / "robot_code.py").write_text(source, encoding="utf-8")
    return analyse("robot_code", tmp_path)


def read(message: Message) -> tuple[str, dict[str, tuple[str, ...]]]:
    return message.form, {part.name: tuple(value.text for value in part.values) for part in message.fields}


def ports_of(tmp_path: Path, findings: Findings) -> Any:
    """The module of the drafted ports, executed."""
    texts = dict(files(Draft(findings, "robot_code", "person", tmp_path)))
    for file, text in texts.items():
        if file.endswith(".py"):
            ast.parse(text)
    tomllib.loads(texts["requirements.toml"])
    module = ModuleType("drafted_ports")
    sys.modules["drafted_ports"] = module
    exec(compile(texts["ports.py"].replace("from world import World\n", ""), "ports.py", "exec"), module.__dict__)
    return module


READ = {
    "TEXTS": (
        ("text", {"text": ("go", "stop")}),
        ("text", {"text": ("sleeping", "moving", "arrived", "stopped", "what?")}),
    ),
    "DICTS": (
        ("dict", {"kind": ("order", "cancel"), "table": ()}),
        ("dict", {"state": ("waiting", "fetching", "serving"), "load": ()}),
    ),
    "TUPLES": (
        ("tuple", {"kind": ("move", "halt"), "value": ()}),
        ("tuple", {"kind": ("moving", "done", "halted"), "value": ()}),
    ),
    "JSON": (
        ("json", {"cmd": ("pick", "place"), "speed": ()}),
        ("json", {"event": ("picking", "holding", "parked", "refused"), "speed": ()}),
    ),
    "TERMINAL": (
        ("text", {"text": ("tea", "quit", "exit")}),
        ("text", {"text": ("brewing tea", "bye", "I do not understand")}),
    ),
    "LINES": (("line", {"text": ("MOVE 1", "WHERE 1")}), ("line", {"text": ("OK", "ERR")})),
}


@pytest.mark.parametrize("name", READ)
def test_messages_without_a_class_have_their_keys_and_values(name: str, tmp_path: Path) -> None:
    findings = found(tmp_path, getattr(plain_robots, name))
    heard, said = READ[name]
    assert [read(message) for message in findings.heard] == [heard]
    assert [read(message) for message in findings.said if message.form != "state"] == [said]
    kinds = {part.name: part.kind for message in findings.messages for part in message.fields}
    assert {kinds.get(number, "float") for number in ("table", "load", "value", "speed")} == {"float"}


@pytest.mark.parametrize(
    ("name", "heard", "said", "as_code_has_it"),
    [
        ("TEXTS", {"text": "go"}, "moving", "go"),
        ("DICTS", {"kind": "order", "table": 2.0}, {"state": "serving"}, {"kind": "order", "table": 2.0}),
        ("TUPLES", {"kind": "move", "value": 3.0}, ("done", 3), ("move", 3.0)),
        ("LINES", {"text": "WHERE"}, b"OK", b"WHERE\n"),
        ("JSON", {"cmd": "pick", "speed": 0.5}, '{"event": "holding"}', '{"cmd": "pick", "speed": 0.5}'),
    ],
)
def test_a_drafted_class_becomes_what_the_code_has_and_back(
    name: str, heard: dict[str, Any], said: Any, as_code_has_it: Any, tmp_path: Path
) -> None:
    findings = found(tmp_path, getattr(plain_robots, name))
    ports = ports_of(tmp_path, findings)
    message = getattr(ports, findings.heard[0].name)(**heard)
    assert ports.to_plain(message) == as_code_has_it
    kind = getattr(ports, findings.said[0].name)
    back = ports.of_plain(said, (kind,))
    assert isinstance(back, kind)
    first = findings.said[0].fields[0].name
    assert getattr(back, first) in ("moving", "serving", "done", "holding", "OK")
    assert ports.of_plain(None, (kind,)) is None


def test_a_queue_of_a_function_is_a_question_with_its_place(tmp_path: Path) -> None:
    source = "import queue\n\ndef main():\n    inbox = queue.Queue()\n    if inbox.get() == 'go':\n        pass\n"
    findings = found(tmp_path, source)
    assert not findings.messages
    question = next(question for question in findings.questions if "inbox" in question.text)
    assert "is made within a function: the draft cannot reach it" in question.text
    assert str(question.place) == "robot_code.py:5"


def test_what_comes_through_a_queue_and_is_not_read_is_a_question(tmp_path: Path) -> None:
    findings = found(tmp_path, "def run(inbox, use):\n    while True:\n        use(inbox.get())\n")
    texts = [question.text for question in findings.questions]
    assert "What comes through `inbox`? Nothing is done with it that says so" in texts


def test_a_queue_between_parts_of_the_code_is_no_message(tmp_path: Path) -> None:
    source = plain_robots.TEXTS.replace("    state = ", "    outbox.get()\n    state = ", 1)
    assert not found(tmp_path, source).said


def test_a_state_that_is_only_held_is_looked_at_in_runs(tmp_path: Path) -> None:
    findings = found(tmp_path, plain_robots.HELD)
    assert [read(message) for message in findings.said] == [
        ("state", {"name": ("closed", "opening", "open", "closing")})
    ]
    assert findings.state == "gate_state.name"
    texts = dict(files(Draft(findings, "robot_code", "person", tmp_path)))
    assert "partial(look, run, lambda: made.state)" in texts["conftest.py"]
    ports = ports_of(tmp_path, findings)
    assert ports.GateState("open").name == "open"


@pytest.mark.parametrize(
    "numbers", ["IDLE, MOVING, LIFTING, ERROR = range(4)", "IDLE = 0\nMOVING = 1\nLIFTING = 2\nERROR = 3"]
)
def test_a_state_that_is_a_number_has_the_name_of_its_constant(numbers: str, tmp_path: Path) -> None:
    code = plain_robots.NUMBERED.replace("IDLE, MOVING, LIFTING, ERROR = range(4)", numbers)
    findings = found(tmp_path, code)
    (state,) = (message for message in findings.messages if message.form == "state")
    assert findings.state == "fork_state.name"
    assert {value.text for value in state.fields[0].values} == {"IDLE", "MOVING", "LIFTING", "ERROR"}

    class Made:
        state = 2

    assert eval(state.channel, {"made": Made()}) == "LIFTING"


def test_a_stand_in_of_a_function_can_be_called(tmp_path: Path) -> None:
    findings = found(tmp_path, plain_robots.NUMBERED)
    text = dict(files(Draft(findings, "robot_code", "person", tmp_path)))["ports.py"]
    log = text[text.index("class Log:") :]
    assert "def __call__(self, *_: Any, **__: Any) -> Any:" in log
    assert 'record("log_did", "call")' in log


def test_a_state_that_is_told_is_not_looked_at(tmp_path: Path) -> None:
    findings = found(tmp_path, plain_robots.JSON)
    assert [message.form for message in findings.said] == ["json"]


def test_topics_that_are_texts_have_what_comes_with_them(tmp_path: Path) -> None:
    findings = found(tmp_path, plain_robots.TOPICS)
    assert {message.channel: read(message) for message in findings.heard} == {
        "command": ("dict", {"action": ("clean", "dock")}),
        "battery": ("number", {"number": ()}),
    }
    assert {message.channel: read(message) for message in findings.said} == {
        "alarm": ("text", {"text": ("battery low",)}),
        "state": ("dict", {"name": ("cleaning", "docked")}),
    }
    assert findings.state == "state_dict.name"
    ports = ports_of(tmp_path, findings)
    assert ports.HEARD["command"] == (ports.CommandDict,)
    assert ports.HEARD["battery"] == (ports.BatteryNumber,)
    assert ports.SAID["alarm"] == (ports.AlarmText,)


def test_a_bus_that_calls_back_and_one_that_cannot_be_reached(tmp_path: Path) -> None:
    findings = found(tmp_path, plain_robots.CALLED_BACK)
    assert findings.entry is not None
    assert (findings.entry.name, findings.entry.is_made, findings.entry.is_async) == ("Door", True, True)
    assert {message.channel: read(message) for message in findings.messages} == {
        "open": ("text", {"text": ("guest",)}),
        "speed": ("text", {"text": ()}),
        "door": ("tuple", {"kind": ("opening", "open"), "who": ()}),
    }
    texts = [question.text for question in findings.questions]
    assert "What is done with the topic 'speed'? No function of the code is called with it" in texts
    assert any("carries the topic 'hall/light', and is no parameter of what runs the robot" in text for text in texts)
    ports = ports_of(tmp_path, findings)
    assert ports.Bus.on is ports.Bus.subscribe
    assert ports.Bus.emit is ports.Bus.publish


@pytest.mark.parametrize("how", plain_robots.HANDLERS)
def test_events_have_a_field_for_each_keyword(how: str, tmp_path: Path) -> None:
    parameters, content = plain_robots.HANDLERS[how]
    code = plain_robots.EVENTS_WITH_KEYWORDS.replace("_on_parcel(self, data)", f"_on_parcel({parameters})")
    findings = found(tmp_path, code.replace("_parcel = data", f"_parcel = {content}"))
    fields = {message.name: [(part.name, part.kind) for part in message.fields] for message in findings.messages}
    assert fields["ParcelDict"] == [("weight_kg", "float"), ("size", "str")]
    assert fields["ModeDict"] == [("name", "str"), ("at", "float")]
    assert fields["RejectedDict"] == [("reason", "str")]
    assert fields["SortedDict"] == [("lane", "float")]
    assert findings.state == "mode_dict.name"


def test_a_first_parameter_that_may_be_the_event_is_asked_for(tmp_path: Path) -> None:
    code = plain_robots.EVENTS_WITH_KEYWORDS.replace("_on_parcel(self, data)", "_on_parcel(self, name, data)")
    asked = [question.text for question in found(tmp_path, code).questions]
    assert "Is `name` of `_on_parcel` the event, as the draft has it, or does it come with it?" in asked


def test_further_arguments_of_an_event_are_fields(tmp_path: Path) -> None:
    code = plain_robots.EVENTS_WITH_KEYWORDS.replace("name=mode, at=time.perf_counter()", "mode, time.perf_counter()")
    message = next(m for m in found(tmp_path, code).messages if m.channel == "mode")
    assert message.form == "tuple"
    assert [part.kind for part in message.fields] == ["str", "float"]


@pytest.mark.slow
@pytest.mark.parametrize("how", ["keywords", "the sender, and keywords"])
def test_events_with_keywords_come_and_go_in_a_draft(how: str, tmp_path: Path) -> None:
    parameters, content = plain_robots.HANDLERS[how]
    code = plain_robots.EVENTS_WITH_KEYWORDS.replace("_on_parcel(self, data)", f"_on_parcel({parameters})")
    code = code.replace("_parcel = data", f"_parcel = {content}")
    (tmp_path / "robot_code.py").write_text(code, encoding="utf-8")
    command = [sys.executable, "-m", "pytest_hricdv", "init", "hri", "--from", "robot_code", "--no-run"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-q", "--hri-tests=8"]
    done = subprocess.run(command, cwd=tmp_path / "hri", capture_output=True, text=True, check=False)
    reported = json.loads((tmp_path / "hri" / "hri-report" / "report.json").read_text(encoding="utf-8"))
    heard = [line.split("\t") for test in reported["tests"] for line in test["timeline"]["messages"]]
    told = {json.loads(content)["name"] for _, _, name, content in heard if name == "mode_dict"}
    assert {"gripping", "sorting", "idle"} <= told, done.stdout
    lanes = {json.loads(content)["lane"] for _, _, name, content in heard if name == "sorted_dict"}
    assert lanes <= {1.0, 2.0, 3.0}
    assert lanes


@pytest.mark.slow
@pytest.mark.parametrize(
    ("subscribe", "get", "publish"),
    [
        ("subscribe", "get()", "publish"),
        ("listen", "recv(timeout=600.0)", "send"),
        ("subscribe", "wait(600.0)", "emit"),
    ],
)
def test_a_bus_with_other_verbs_and_queues_is_one_of_the_draft(
    subscribe: str, get: str, publish: str, tmp_path: Path
) -> None:
    code = plain_robots.INBOXES.replace("bus.subscribe", f"bus.{subscribe}").replace("inbox.get()", f"inbox.{get}")
    (tmp_path / "robot_code.py").write_text(code.replace("bus.publish", f"bus.{publish}"), encoding="utf-8")
    command = [sys.executable, "-m", "pytest_hricdv", "init", "hri", "--from", "robot_code", "--no-run"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-q", "--hri-tests=4"]
    done = subprocess.run(command, cwd=tmp_path / "hri", capture_output=True, text=True, check=False)
    assert "raised" not in done.stdout
    reported = json.loads((tmp_path / "hri" / "hri-report" / "report.json").read_text(encoding="utf-8"))
    names = {line.split("\t")[2] for test in reported["tests"] for line in test["timeline"]["messages"]}
    assert {"switch", "light"} <= names


def test_what_is_said_and_is_like_no_message_is_warned_of() -> None:
    names: dict[str, Any] = {}
    imports = "import json, warnings\nfrom enum import Enum\nfrom dataclasses import fields\nfrom typing import Any\n"
    exec(imports + CONVERTING, names)  # as the draft's `ports.py` has it
    of_plain = names["of_plain"]
    with pytest.warns(UserWarning, match=r"the code says 3, which is no Lamp: no test sees it"):
        assert of_plain(3, (type("Lamp", (), {"FORM": "text"}),)) is None
    assert of_plain(3, ()) is None


def test_what_is_printed_counts_where_nothing_else_is_said(tmp_path: Path) -> None:
    findings = found(tmp_path, plain_robots.TEXTS.replace('outbox.put("what?")', 'print("what?")'))
    assert [message.channel for message in findings.said] == ["outbox"]
    terminal = found(tmp_path, plain_robots.TERMINAL)
    assert [channel.variables for channel in terminal.channels] == [
        (("robot_code", "print"),),
        (("robot_code", "input"),),
    ]
    assert not [problem for problem in terminal.problems if problem.kind == "terminal"]


@pytest.mark.slow
def test_code_of_which_nothing_is_read_has_a_draft_that_says_so(tmp_path: Path) -> None:
    (tmp_path / "robot_code.py").write_text("LIMIT = 3\n", encoding="utf-8")
    command = [sys.executable, "-m", "pytest_hricdv", "init", "draft", "--from", "robot_code"]
    made = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stderr
    assert "nothing was found that robot_code hears or says: its tests are nearly empty until" in made.stdout


@pytest.mark.slow
def test_code_that_raises_with_stand_ins_has_a_draft_that_says_so(tmp_path: Path) -> None:
    source = "class Lamp:\n    def run(self):\n        raise RuntimeError('no lamp at /dev/lamp0')\n"
    (tmp_path / "robot_code.py").write_text(source, encoding="utf-8")
    command = [sys.executable, "-m", "pytest_hricdv", "init", "draft", "--from", "robot_code"]
    made = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stderr
    assert "first runs: robot_code.py:3: RuntimeError: no lamp at /dev/lamp0: the draft is not green" in made.stdout
    assert "no lamp at /dev/lamp0" in (tmp_path / "draft" / "README.md").read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("name", [*READ, "HELD", "TOPICS"])
def test_a_draft_of_code_without_classes_is_green_at_once(name: str, tmp_path: Path) -> None:
    (tmp_path / "robot_code.py").write_text(getattr(plain_robots, name), encoding="utf-8")
    command = [sys.executable, "-m", "pytest_hricdv", "init", "draft", "--from", "robot_code"]
    made = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stderr
    heard, said = {"TERMINAL": (1, 2), "HELD": (0, 1), "TOPICS": (2, 2)}.get(name, (1, 1))
    assert f"read: {heard} messages heard, {said} said" in made.stdout
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q"], cwd=tmp_path / "draft", capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout
    assert f"tests: {6 if name == 'HELD' else 30} passed" in done.stdout


def test_a_function_called_as_what_a_run_needs_is_not_imported_under_its_name(tmp_path: Path) -> None:
    source = (
        "def run(inbox, outbox):\n    while True:\n        if inbox.get() == 'go':\n            outbox.put('gone')\n"
    )
    findings = found(tmp_path, source)
    text = dict(files(Draft(findings, "robot_code", "person", tmp_path)))["conftest.py"]
    assert 'make: Any = import_module("robot_code").run' in text
    assert "import run" not in text


def test_an_annotation_that_is_a_text_is_read(tmp_path: Path) -> None:
    source = """
import queue
from dataclasses import dataclass


@dataclass
class Go:
    where: str


def work(inbox: "queue.Queue[Go]"):
    while True:
        print(inbox.get().where)
"""
    assert [message.name for message in found(tmp_path, source).heard] == ["Go"]


@pytest.mark.parametrize("guard", ["", 'if __name__ == "__main__":\n    '])
def test_a_program_without_a_function_is_executed_with_its_terminal(guard: str, tmp_path: Path) -> None:
    indent = "    " if guard else ""
    lines = ["while True:", "    word = input()", "    if word == 'go':", "        print('gone')"]
    findings = found(tmp_path, guard + ("\n" + indent).join(lines) + "\n")
    assert findings.script == "robot_code"
    assert [read(message) for message in findings.heard] == [("text", {"text": ("go",)})]
    text = dict(files(Draft(findings, "robot_code", "person", tmp_path)))["conftest.py"]
    assert 'run_script("robot_code", {"input": input_, "print": ' in text


def test_lines_of_standard_input_are_heard(tmp_path: Path) -> None:
    source = "import sys\nfor line in sys.stdin:\n    if line.strip() == 'go':\n        print('gone')\n"
    findings = found(tmp_path, source)
    assert [(message.channel, read(message)) for message in findings.heard] == [("stdin", ("text", {"text": ("go",)}))]


def test_a_module_that_hides_one_of_python_is_said(tmp_path: Path) -> None:
    (tmp_path / "queue.py").write_text("def run(inbox):\n    inbox.get()\n", encoding="utf-8")
    texts = [problem.text for problem in analyse("queue", tmp_path).problems]
    assert any("has the name of a module of Python's own" in text for text in texts)


def test_a_program_that_starts_processes_is_not_what_is_tested(tmp_path: Path) -> None:
    source = """
import multiprocessing as mp


class Worker(mp.Process):
    def __init__(self, tasks: mp.Queue, results: mp.Queue):
        super().__init__()
        self.tasks, self.results = tasks, results

    def run(self):
        while True:
            if self.tasks.get() == "go":
                self.results.put("gone")


def main():
    tasks, results = mp.Queue(), mp.Queue()
    Worker(tasks, results).start()
    tasks.put("go")
    print(results.get())
"""
    findings = found(tmp_path, source)
    assert findings.entry is not None
    assert (findings.entry.name, findings.entry.method) == ("Worker", "run")
