"""Who calls the code of a drafted robot from outside, as text: the class in `ports.py`, and its lines in a run."""

from __future__ import annotations

from pytest_hricdv.extra.draft.found.findings import Calling
from pytest_hricdv.extra.draft.writing.drafted import Draft

_CALLS = '''

BUGS = (TypeError, AttributeError, NameError, AssertionError, ImportError, SyntaxError)
"""What a call raises that is wrong in the code; all else is its answer."""


@dataclass(frozen=True)
class CallFailed:
    """The code answered a call by raising this."""

    call: str = ""
    error: str = ""


class Calls:
    """Who calls the code from outside: for each message that a person says, a function is called."""

    def __init__(self, run: Run, said: dict[type[Any], tuple[type[Any], ...]]) -> None:
        self._run, self._said, self._port = run, said, run.bus.port("robot"){more}

{on}
{talk}    def _tell(self, kind: type[Any], value: Any) -> None:
        """Say what was returned."""
        message = of_plain(value, self._said.get(kind, ()))
        if message is not None:
            self._port.publish(message)

    def _fail(self, kind: type[Any], error: Exception) -> None:
        """Say what was raised."""
        if isinstance(error, BUGS) or type(error).__module__.startswith("pytest_hricdv"):
            raise error
        self._port.publish(CallFailed(kind.__name__, type(error).__name__))
'''

_TALK = '''    def talk(self, kind: type[Any], content: Any) -> Talk:
        """A connection by which this comes, once; what is sent is said."""
        return Talk(content, partial(self._tell, kind))

'''

_TALK_CLASS = '''

class Talk:
    """A connection that a function of the code is called with."""

    def __init__(self, content: Any, tell: Callable[[Any], None]) -> None:
        self._next, self._tell = [content], tell

    {async}def recv(self, *_: Any, **__: Any) -> Any:
        """What comes; empty when it has come."""
        return self._next.pop() if self._next else b""

    read = readline = recv_json = recv_string = receive = receive_json = receive_text = receive_bytes = recv

    {async}def send(self, data: Any, *_: Any, **__: Any) -> None:
        """Say it."""
        self._tell(data.decode(errors="replace").strip() if isinstance(data, bytes) else data)

    sendall = send_json = send_string = send_text = send_bytes = write = send

    def __aiter__(self) -> Talk:
        return self

    async def __anext__(self) -> Any:
        if not self._next:
            raise StopAsyncIteration
        return self._next.pop()

    def __getattr__(self, name: str) -> Any:
        """What else it can do, such as `close`, does nothing."""
        if name.startswith("__"):
            raise AttributeError(name)
        return lambda *_, **__: None
'''

_SYNC = '''    def on(self, kind: type[Any], call: Callable[[Any], Any]) -> None:
        """Call a function of the code for each message of a class{how}."""
        heard = self._port.subscribe(kind)

        def hear() -> None:
            while True:
                message = heard.wait(REST_OF_RUN_S)
                if message is not None:{turn}
                    try:
                        self._tell(kind, call(message))
                    except Exception as error:
                        self._fail(kind, error)
{end}
        self._run.kernel.spawn(f"calls {kind.__name__}", self._run.measured(hear))
'''

_TURN = """
                    while self._is_calling:
                        self._run.kernel.sleep(LOOKS_EACH_S)
                    self._is_calling = True"""

_TURN_END = """                    self._is_calling = False
"""

_ASYNC = '''    def on(self, kind: type[Any], call: Callable[[Any], Any]) -> None:
        """Call a function of the code for each message of a class, in a task of its own."""
        self._tasks.append(asyncio.ensure_future(self._hear(kind, Inbox(self._run, kind, taken=lambda m: m), call)))

    async def _hear(self, kind: type[Any], inbox: Inbox, call: Callable[[Any], Any]) -> None:
        while True:
            message = await inbox.get()
            try:
                value = call(message)
                self._tell(kind, await value if asyncio.iscoroutine(value) else value)
            except Exception as error:
                self._fail(kind, error)
'''

_REQUEST = '''

def with_request(module: str, content: Any, call: Callable[..., Any], *arguments: Any) -> Any:
    """Call a function of a web server with a request of this content; what it returns, without a status."""
    names = import_module(module).__dict__
    names["request"] = SimpleNamespace(
        json=content, form=content, args=content, values=content, data=json.dumps(content).encode(), headers={},
        method="POST", get_json=lambda *_, **__: content,
    )
    names["jsonify"] = lambda *parts, **named: parts[0] if parts else named
    value = call(*arguments)
    return value[0] if isinstance(value, tuple) and value and isinstance(value[-1], int) else value
'''


def call_classes(draft: Draft) -> str:
    """The class of those who call; empty where nobody does."""
    if not draft.findings.calls:
        return ""
    is_threaded = "threading" in draft.findings.virtual
    if draft.is_async:
        on, more = _ASYNC, "\n        self._tasks: list[Any] = []"
    else:
        on = _SYNC.replace("{turn}", "" if is_threaded else _TURN).replace("{end}", "" if is_threaded else _TURN_END)
        on = on.replace("{how}", "" if is_threaded else ", one after the other")
        more = "" if is_threaded else "\n        self._is_calling = False"
    is_talk = any("calls.talk(" in part for calling in draft.findings.calls for part in calling.arguments)
    text = _TALK_CLASS.replace("{async}", "async " if draft.is_async else "") if is_talk else ""
    text += _CALLS.replace("{more}", more).replace("{on}", on).replace("{talk}", _TALK if is_talk else "")
    return text + (_REQUEST if any(calling.request for calling in draft.findings.calls) else "")


def call_lines(draft: Draft) -> list[str]:
    """Lines of a run that let somebody call the code."""
    calls = draft.findings.calls
    if not calls:
        return []
    lines = ["calls = Calls(", "    run,", "    {"]
    for calling in calls:
        if calling.said:
            said = f"({', '.join(calling.said)}{',' if len(calling.said) == 1 else ''})"
            lines.append(f"        {calling.message}: {said},")
    lines += ["    },", ")"] if any(calling.said for calling in calls) else []
    lines = lines if any(calling.said for calling in calls) else ["calls = Calls(run, {})"]
    return [*lines, *(_line(calling) for calling in calls)]


def _line(calling: Calling) -> str:
    arguments = [part for part in calling.arguments if not part.startswith("request=")]
    given = next((part.removeprefix("request=") for part in calling.arguments if part.startswith("request=")), "{}")
    called = f"{calling.target}({', '.join(arguments)})"
    if calling.request:
        called = f"with_request({', '.join([repr_text(calling.request), given, calling.target, *arguments])})"
    name = "message" if "message." in called else "_"
    return f"calls.on({calling.message}, lambda {name}: {called})  # {calling.place}"


def repr_text(text: str) -> str:
    """A text as source, with double quotes."""
    return f'"{text}"'


def call_needs(draft: Draft) -> list[tuple[str, str]]:
    """Names that these lines need, as (module, name)."""
    calls = draft.findings.calls
    if not calls:
        return []
    needs = [("ports", "Calls"), *(("ports", calling.message) for calling in calls)]
    needs += [("ports", name) for calling in calls for name in calling.said]
    needs += [need for calling in calls for need in calling.needs]
    needs += [("ports", "with_request")] if any(calling.request for calling in calls) else []
    if any("Anything()" in part for calling in calls for part in calling.arguments):
        needs.append(("ports", "Anything"))
    return needs
