"""The ports of a draft: what the code is handed in place of its hardware, its bus and its queues."""

from __future__ import annotations

import re

from pytest_hricdv.extra.draft.drafted import Draft
from pytest_hricdv.extra.draft.findings import Operation, Port
from pytest_hricdv.extra.draft.messages import SAYS, SUBSCRIBES
from pytest_hricdv.extra.draft.naming import camel
from pytest_hricdv.extra.draft.plain_text import plain_classes

_ANYTHING = '''

class Anything:
    """In place of what is not known: it has each attribute, can be called, and says nothing."""

    def __getattr__(self, name: str) -> Anything:
        if name.startswith("__"):
            raise AttributeError(name)
        return Anything()

    def __call__(self, *_: Any, **__: Any) -> Anything:
        return Anything()

    def __await__(self) -> Iterator[Any]:
        return iter(())

    def __getitem__(self, _: Any) -> Anything:
        return Anything()

    def __iter__(self) -> Iterator[Any]:
        return iter(())

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        return None

    def __len__(self) -> int:
        return 0

    def __bool__(self) -> bool:
        return False

    def __float__(self) -> float:
        return 0.0

    def __int__(self) -> int:
        return 0

    def __index__(self) -> int:
        return 0

    def _number(self, *_: Any) -> float:
        return 0.0

    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = _number
    __truediv__ = __neg__ = __abs__ = __or__ = __and__ = _number

    def __lt__(self, other: Any) -> bool:
        return bool(other > 0)

    def __gt__(self, other: Any) -> bool:
        return bool(other < 0)

    def __le__(self, other: Any) -> bool:
        return bool(other >= 0)

    def __ge__(self, other: Any) -> bool:
        return bool(other <= 0)
'''

_MISSING = '''

class Missing(ModuleType):
    """In place of a module that is not installed here."""

    __path__: list[str] = []  # so that it has submodules

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return type(name, (Anything,), {}) if name[:1].isupper() and not name.isupper() else Anything()


class MissingModules(MetaPathFinder, Loader):
    """Finds the modules that are not installed, and hands out stand-ins."""

    def find_spec(self, fullname: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        """For these modules only."""
        return ModuleSpec(fullname, self, is_package=True) if fullname.partition(".")[0] in MISSING else None

    def create_module(self, spec: ModuleSpec) -> Missing:
        """A stand-in."""
        return Missing(spec.name)

    def exec_module(self, module: ModuleType) -> None:
        """There is nothing to execute."""


def stand_in_for_missing_modules() -> None:
    """Let the code be imported, without what is not installed."""
    if not any(isinstance(finder, MissingModules) for finder in sys.meta_path):
        sys.meta_path.insert(0, MissingModules())
'''

_SYNC_QUEUES = '''

class Inbox:
    """A queue that the code takes from: what a person says goes into it."""

    def __init__(self, run: Run, *kinds: type[Any], taken: Callable[[Any], Any] = {taken}) -> None:
        self._kernel, self._taken = run.kernel, taken
        self._heard = [run.bus.port("robot").subscribe(kind) for kind in kinds]
        self._next: list[Any] = []

    def _look(self) -> bool:
        """Whether there is a message."""
        for heard in self._heard:
            message = None if self._next else heard.poll()
            if message is not None:
                self._next.append(self._taken(message))
        return bool(self._next)

    def get(self, block: bool = True, timeout: float | None = None) -> Any:
        """The oldest message; raises queue.Empty like a queue."""
        ends_s = self._kernel.now_s + (REST_OF_RUN_S if timeout is None else timeout) if block else self._kernel.now_s
        while not self._look():
            left_s = ends_s - self._kernel.now_s
            if left_s <= 0.0:
                raise queue.Empty
            if len(self._heard) == 1:
                message = self._heard[0].wait(left_s)
                if message is not None:
                    return self._taken(message)
            else:
                self._kernel.sleep(min(LOOKS_EACH_S, left_s))
        return self._next.pop(0)

    def get_nowait(self) -> Any:
        """The same without waiting."""
        return self.get(block=False)

    def __call__(self, *_: Any) -> Any:
        """In place of a function that waits for something, such as `input`."""
        return self.get()

    def empty(self) -> bool:
        """Whether there is none."""
        return not self._look()

    def qsize(self) -> int:
        """One where there is any."""
        return int(self._look())

    def full(self) -> bool:
        """It takes all."""
        return False

    def task_done(self) -> None:
        """Nobody waits for it."""

    def join(self) -> None:
        """Nobody waits for it."""
'''

_ASYNC_QUEUES = '''

class Inbox:
    """A queue of an event loop that the code takes from: what a person says goes into it."""

    def __init__(self, run: Run, *kinds: type[Any], taken: Callable[[Any], Any] = {taken}) -> None:
        self._queue: asyncio.Queue[Any] = asyncio.Queue()
        self._loop, self._taken = asyncio.get_running_loop(), taken
        for kind in kinds:
            heard = run.bus.port("robot").subscribe(kind)
            run.kernel.spawn(f"robot hears {kind.__name__}", partial(self._hear, heard))

    def _hear(self, heard: Any) -> None:
        while not self._loop.is_closed():
            message = heard.wait(REST_OF_RUN_S)
            if message is not None and not self._loop.is_closed():
                self._loop.call_soon_threadsafe(self._queue.put_nowait, self._taken(message))

    async def get(self) -> Any:
        """The oldest message; waits for one where there is none."""
        return await self._queue.get()

    def get_nowait(self) -> Any:
        """The same without waiting; raises asyncio.QueueEmpty."""
        return self._queue.get_nowait()

    def empty(self) -> bool:
        """Whether there is none."""
        return self._queue.empty()

    def qsize(self) -> int:
        """How many there are."""
        return self._queue.qsize()

    def task_done(self) -> None:
        """Nobody waits for it."""

    def __aiter__(self) -> Inbox:
        return self

    async def __anext__(self) -> Any:
        return await self.get()
'''

_OUTBOX = '''

class Outbox:
    """A queue, or a function, that the code hands messages to: the robot says them."""

    def __init__(self, run: Run{kinds}) -> None:
        self._port = run.bus.port("robot"){remember}

    def __call__(self, *arguments: Any) -> None:
        """Say it. TODO: what is of none of these classes is not said: which message is it?"""
        message = {message}
        if is_dataclass(message):
            self._port.publish(message)

    put_nowait = __call__

    {put}
        """Say it; it never waits."""
        self({value})

    def empty(self) -> bool:
        """All that is said is taken at once."""
        return True

    def qsize(self) -> int:
        """Nothing waits in it."""
        return 0

    def full(self) -> bool:
        """It takes all."""
        return False
'''

_STREAM = '''

class Stream:
    """A stream of lines, or its reading or writing half."""

    def __init__(self, run: Run, heard: tuple[type[Any], ...], said: tuple[type[Any], ...]) -> None:
        self._inbox, self._port, self._said = Inbox(run, *heard), run.bus.port("robot"), said

    {async}def readline(self, *_: Any, **__: Any) -> bytes:
        """{readline_doc}"""
        {readline}

    read = readuntil = readexactly = read_until = readline

    @property
    def in_waiting(self) -> int:
        """Whether there is a line."""
        return self._inbox.qsize()

    def at_eof(self) -> bool:
        """The other side stays."""
        return False

    def write(self, data: bytes) -> int:
        """Say each line."""
        for line in data.decode(errors="replace").splitlines():
            message = of_plain(line, self._said)
            if message is not None:
                self._port.publish(message)
        return len(data)

    def writelines(self, lines: Any) -> None:
        """Say them."""
        for line in lines:
            self.write(line)

    {async}def drain(self) -> None:
        """Nothing waits in it."""

    flush = wait_closed = drain

    def close(self) -> None:
        """The other side stays."""

    def is_closing(self) -> bool:
        """It stays open."""
        return False

    def get_extra_info(self, name: str, default: Any = None) -> Any:
        """There is none."""
        return default
'''

_READLINE = """try:
            line: bytes = self._inbox.get(timeout=READ_S)
        except queue.Empty:
            return b""
        return line"""

_ASYNC_BUS = '''

class Bus:
    """What the code's bus does, on the bus of the test."""

    def __init__(self, run: Run) -> None:
        self._run = run
        self._port = run.bus.port("robot")

    def publish(self, message: Any) -> None:
        """Say it."""
        self._port.publish(message)

    def subscribe(self, kind: type[Any], callback: Callable[[Any], Any] | None = None) -> Inbox:
        """An inbox for messages of this class; with a callback, this is called for each."""
        inbox = Inbox(self._run, kind)
        if callback is not None:
            self._calling = asyncio.ensure_future(self._call(inbox, callback))
        return inbox

    async def _call(self, inbox: Inbox, callback: Callable[[Any], Any]) -> None:
        while True:
            made = callback(await inbox.get())
            if asyncio.iscoroutine(made):
                await made
'''

_CALLBACK_BUS = '''

class Bus:
    """What the code's bus does, on the bus of the test: it calls back."""

    def __init__(self, run: Run) -> None:
        self._run = run
        self._port = run.bus.port("robot")

    def publish(self, message: Any) -> None:
        """Say it."""
        self._port.publish(message)

    def subscribe(self, kind: type[Any], callback: Callable[[Any], Any]) -> None:
        """Call back for each message of this class, in a node of its own, as the thread of a middleware does."""
        heard = self._port.subscribe(kind)

        def hear() -> None:
            while True:
                message = heard.wait(REST_OF_RUN_S)
                if message is not None:
                    callback(message)

        self._run.kernel.spawn(f"robot hears {kind.__name__}", self._run.measured(hear))
'''


_TOPIC_BUS = '''

class Bus:
    """What the code's bus does, on the bus of the test: topics are texts, and it calls back."""

    def __init__(self, run: Run) -> None:
        self._run, self._port = run, run.bus.port("robot")

    {async}def publish(self, topic: Any, message: Any = "", *_: Any, **__: Any) -> None:
        """Say it."""
        said = next((one for one in (topic, message) if is_dataclass(one)), None)
        said = of_plain(message, SAID.get(topic, ())) if said is None else said
        if said is not None:
            self._port.publish(said)

    {async_subscribe}def subscribe(self, topic: Any, callback: Callable[..., Any] | None = None, *_: Any) -> Any:
        """Call back for each message of the topic; without a callback, an inbox for them."""
        kinds = HEARD.get(topic, ()) if isinstance(topic, str) else (topic,)
        if callback is None:
            return Inbox(self._run, *kinds)
        count = len(signature(callback).parameters)

        def call(content: Any) -> Any:
            return callback(*(topic, content)[2 - min(count, 2) :])

{hearing}
        return None
{aliases}'''

_HEARING = """        def hear(heard: Any) -> None:
            while True:
                message = heard.wait(REST_OF_RUN_S)
                if message is not None:
                    call(to_plain(message))

        for kind in kinds:
            heard = self._port.subscribe(kind)
            self._run.kernel.spawn(f"robot hears {kind.__name__}", self._run.measured(partial(hear, heard)))"""

_ASYNC_HEARING = """        async def hear(inbox: Inbox) -> None:
            while True:
                made = call(await inbox.get())
                if asyncio.iscoroutine(made):
                    await made

        self._hearing = [*getattr(self, "_hearing", ()), asyncio.ensure_future(hear(Inbox(self._run, *kinds)))]"""


def _topic_bus(draft: Draft) -> str:
    """The bus of topics that are texts, with the names that the code calls its methods by."""
    bus = next(port for port in draft.ports if port.role == "bus")
    lines = []
    for name, side in (("HEARD", "heard"), ("SAID", "said")):
        by_topic: dict[str, list[str]] = {}
        for message in draft.topics:
            if message.direction == side:
                by_topic.setdefault(message.channel, []).append(message.name)
        pairs = [f"    {topic!r}: ({', '.join(kinds)},),".replace("'", '"') for topic, kinds in by_topic.items()]
        lines += ["", f"{name}: dict[str, tuple[type[Any], ...]] = {{", *pairs, "}"]
    used = {operation.name: operation.is_async for operation in bus.operations}
    says = [name for name in used if name.strip("_") in SAYS and name != "publish"]
    hears = [name for name in used if name.strip("_") in SUBSCRIBES and name != "subscribe"]
    aliases = [f"    {name} = publish" for name in says] + [f"    {name} = subscribe" for name in hears]
    text = _TOPIC_BUS.replace("{async}", "async " if any(used.get(n) for n in ("publish", *says)) else "")
    is_async = any(used.get(name) for name in ("subscribe", *hears))
    text = text.replace("{async_subscribe}", "async " if is_async else "")
    text = text.replace("{hearing}", _ASYNC_HEARING if draft.is_async else _HEARING)
    return "\n".join(lines) + "\n" + text.replace("{aliases}", "\n".join(["", *aliases, ""]) if aliases else "")


def ports(draft: Draft) -> str:
    """The module of the ports; without what this robot does not need."""
    parts = []
    roles = {port.role for port in draft.ports}
    if draft.missing or any(_is_unknown(operation) for port in draft.devices for operation in port.operations):
        parts.append(_ANYTHING)
    if draft.missing:
        parts.append(_MISSING)
    how = bus_kind(draft)
    is_plain = any(message.form != "state" for message in draft.plain)
    parts.append(plain_classes(draft))
    is_stream = bool(roles & {"reader", "writer"}) and is_plain
    if "queue" in roles or is_stream or how in ("async", "topics") or draft.findings.channels:
        taken = "to_plain" if is_plain else "lambda message: message"
        parts.append((_ASYNC_QUEUES if draft.is_async else _SYNC_QUEUES).replace("{taken}", taken))
    if roles & {"queue", "publish"} or draft.findings.channels:
        parts.append(_outbox(draft))
    if is_stream:
        parts.append(_stream(draft))
    if how == "topics":
        parts.append(_topic_bus(draft))
    if how in ("async", "callback"):
        parts.append(_ASYNC_BUS if how == "async" else _CALLBACK_BUS)
    parts += [_device(draft, port) for port in draft.devices]
    body = "".join(parts)
    return _head(draft, body) + body


def _outbox(draft: Draft) -> str:
    """The class of what is said into; of messages without a class where there are some."""
    is_plain = any(message.form != "state" for message in draft.plain)
    put = "async def put(self, message: Any) -> None:" if draft.is_async else (
        "def put(self, message: Any, *_: Any, **__: Any) -> None:"
    )  # fmt: skip
    message = "arguments[-1]"
    if is_plain:
        message += " if is_dataclass(arguments[-1]) else of_plain(arguments[-1], self._kinds)"
    replaced = {
        "{kinds}": ", *kinds: type[Any]" if is_plain else "",
        "{remember}": "\n        self._kinds = kinds" if is_plain else "",
        "{message}": message,
        "{put}": put,
        "{value}": "message",
    }
    text = _OUTBOX
    for mark, content in replaced.items():
        text = text.replace(mark, content)
    return text


def _stream(draft: Draft) -> str:
    """The class of a stream."""
    is_async = draft.is_async
    text = _STREAM.replace("{async}", "async " if is_async else "")
    text = text.replace("{readline}", "return bytes(await self._inbox.get())" if is_async else _READLINE)
    doc = "The next line; waits for it." if is_async else "The next line; empty where there is none for a while."
    return text.replace("{readline_doc}", doc)


def bus_kind(draft: Draft) -> str:
    """Which bus the code has: "" for none, "own" for one like that of the plugin, "async", "callback", "topics"."""
    bus = next((port for port in draft.ports if port.role == "bus"), None)
    if bus is None:
        return ""
    if draft.topics:
        return "topics"
    if draft.is_async:
        return "async"
    subscribe = next((operation for operation in bus.operations if operation.name == "subscribe"), None)
    return "callback" if subscribe is not None and len(subscribe.arguments) > 1 else "own"


def device_class(port: Port) -> str:
    """The name of a stand-in."""
    return camel(port.name.strip("_"))


def _head(draft: Draft, body: str) -> str:
    lines = [
        '"""What the code is handed in the place of its hardware, its bus and its queues. Replace it part by part."""',
        "",
    ]
    lines += ["from __future__ import annotations", ""]
    modules = ("asyncio", "json", "queue", "sys")
    lines += [f"import {name}" for name in modules if re.search(rf"(?<![\w.]){name}\.", body)]
    names = [name for name in ("Callable", "Iterator") if name in body]
    lines += [f"from collections.abc import {', '.join(names)}"] if names else []
    made = [name for name in ("dataclass", "fields", "is_dataclass") if re.search(rf"\b{name}(\(|$)|@{name}\(", body)]
    lines += [f"from dataclasses import {', '.join(made)}"] if made else []
    lines += ["from enum import Enum"] if re.search(r"Enum\)", body) else []
    lines += ["from functools import partial"] if "partial(" in body else []
    lines += ["from inspect import signature"] if "signature(" in body else []
    if draft.missing:
        lines += ["from importlib.abc import Loader, MetaPathFinder", "from importlib.machinery import ModuleSpec",
                  "from types import ModuleType"]  # fmt: skip
    typed = [name for name in ("Any", "ClassVar", "Self") if re.search(rf"\b{name}\b", body)]
    lines += [f"from typing import {', '.join(typed)}"] if typed else []
    own = ["from pytest_hricdv.runtime import text_of"] if "text_of(" in body else []
    if "Run" in body:
        own.append("from pytest_hricdv.testbench import Run")
    if "World" in body:
        own += ["", "from world import World"] if own else ["from world import World"]
    lines += [*([""] if own else []), *own]
    if draft.missing:
        names_ = ", ".join(f'"{name}"' for name in dict.fromkeys(name.partition(".")[0] for name in draft.missing))
        lines += ["", f"MISSING = ({names_},)"]
    if "REST_OF_RUN_S" in body:
        lines += ["", "REST_OF_RUN_S = 10_000.0  # longer than any run"]
    if "LOOKS_EACH_S" in body:
        lines += ["LOOKS_EACH_S = 0.02"]
    if "READ_S" in body:
        lines += ["READ_S = 1.0  # so long a line is waited for; TODO"]
    if "STATE_EACH_S" in body:
        lines += ["", "STATE_EACH_S = 0.05  # how often the state is looked at"]
    if re.search(r"\bSTEP_S", body):
        lines += [
            "",
            "STEP_S = 0.01  # so long each call of a device takes: a loop that only asks devices would not end",
        ]
    return "\n".join(lines) + "\n"


def _is_unknown(operation: Operation) -> bool:
    return (
        not operation.is_set
        and not operation.made
        and operation.returns not in ("bool", "float", "int", "text", "str", "None")
    )


def _device(draft: Draft, port: Port) -> str:
    """The stand-in of a port."""
    lines = [
        "",
        "",
        f"class {device_class(port)}:",
        f'    """Stand-in of `{port.name}` ({port.place}). TODO: what does it do, and what does it say?"""',
        "",
        "    def __init__(self, world: World) -> None:",
        "        self._world = world",
    ]
    sensors = {sensor.operation.name: sensor for sensor in draft.sensors if sensor.port == port.name}
    lines += [
        f"        self.{o.name}: Any = None  # {o.place}" for o in port.operations if o.kind == "attribute" and o.is_set
    ]
    for operation in port.operations:
        if (operation.kind == "attribute" and operation.is_set) or operation.name.startswith("__"):
            continue
        value = (
            f'self._world.senses["{sensors[operation.name].name}"]' if operation.name in sensors else _value(operation)
        )
        lines.append("")
        if operation.kind == "attribute":
            lines += ["    @property", f"    def {operation.name}(self) -> Any:", f'        """{operation.place}"""']
        else:
            a = "async " if operation.is_async else ""
            lines += [
                f"    {a}def {operation.name}(self, *_: Any, **__: Any) -> Any:",
                f'        """{operation.place}"""',
            ]
            if draft.takes_time and not operation.is_async:
                lines.append("        self._world.sleep(STEP_S)")
            if operation.name not in sensors:
                lines.append(f'        self._world.record("{port.name}_did", "{operation.name}")')
        lines += [f"        from {module} import {name}" for module, name in operation.needs]
        lines.append(f"        return {value}" + ("" if operation.name in sensors else "  # TODO"))
    return "\n".join(lines) + "\n"


def _value(operation: Operation) -> str:
    if operation.made:
        return operation.made
    if operation.returns in ("text", "str"):
        return '""'
    return "Anything()" if _is_unknown(operation) else "None"
