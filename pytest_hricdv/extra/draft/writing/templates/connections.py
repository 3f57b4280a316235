"""The class of a drafted connection, as text: a serial line, a socket, or a client of a broker."""

CONNECTION = '''

class Connection:
    """In place of a serial line, a socket or a client: what a person says is received, and what is sent is said."""

    def __init__(self, run: Run, heard: tuple[type[Any], ...], said: tuple[type[Any], ...], is_text: bool) -> None:
        self._inbox, self._port, self._said = Inbox(run, *heard), run.bus.port("robot"), said
        self._is_text, self._timeout_s = is_text, REST_OF_RUN_S

    def make(self, *_: Any, **named: Any) -> Connection:
        """In place of its constructor."""
        self.settimeout(named.get("timeout"))
        return self

    def settimeout(self, seconds: float | None) -> None:
        """How long is waited for what comes."""
        self._timeout_s = REST_OF_RUN_S if seconds is None else float(seconds)

    {async}def _next(self) -> Any:
        {next}
        if self._is_text and isinstance(content, bytes):
            return content.decode()
        return content.encode() if isinstance(content, str) and not self._is_text else content

    {async}def recv(self, *_: Any, **__: Any) -> Any:
        """What comes next; raises TimeoutError where nothing does."""
        return {await}self._next()

    recv_json = recv_string = recv_pyobj = receive = receive_json = receive_text = receive_bytes = recv

    {async}def recvfrom(self, *_: Any) -> Any:
        """The same, with the address that it comes from."""
        return {await}self._next(), ("127.0.0.1", 1)

    {async}def readline(self, *_: Any, **__: Any) -> Any:
        """The next line; empty where none comes in time."""
        try:
            return {await}self._next()
        except TimeoutError:
            return "" if self._is_text else b""

    read = read_until = read_all = readuntil = readline

    @property
    def in_waiting(self) -> int:
        """Whether there is something."""
        return self._inbox.qsize()

    {async}def send(self, data: Any, *_: Any, **__: Any) -> int:
        """Say it."""
        content = data.decode(errors="replace").strip() if isinstance(data, bytes) else data
        message = of_plain(content, self._said)
        if message is not None:
            self._port.publish(message)
        return len(data) if isinstance(data, bytes | str) else 0

    sendall = sendto = send_json = send_string = send_pyobj = send_text = send_bytes = write = send

    {async}def publish(self, topic: str, payload: Any = "", *_: Any, **__: Any) -> None:
        """Say what goes with a topic."""
        {await}self.send(payload)

    def accept(self) -> tuple[Connection, tuple[str, int]]:
        """The other side is there at once."""
        return self, ("127.0.0.1", 1)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        return None

    def __getattr__(self, name: str) -> Any:
        """What else it can do, such as `connect` and `bind`, does nothing."""
        if name.startswith("__"):
            raise AttributeError(name)
        return lambda *_, **__: None


class Instead:
    """A module, with another class in it."""

    def __init__(self, of: Any, name: str, made: Any) -> None:
        self._of, self._name, self._made = of, name, made

    def __getattr__(self, name: str) -> Any:
        return self._made if name == self._name else getattr(self._of, name)


def instead(module: str, name: str, attribute: str, made: Connection) -> None:
    """Let a module of the code get this connection from `name.attribute()`, or from `name()`."""
    names = import_module(module).__dict__
    names[name] = Instead(names[name], attribute, made.make) if attribute else made.make
'''

_NEXT = """try:
            content = self._inbox.get(timeout=self._timeout_s)
        except queue.Empty:
            raise TimeoutError("nothing came") from None"""

_NEXT_ASYNC = "content = await self._inbox.get()"


def connection_class(is_async: bool) -> str:
    """The class."""
    text = CONNECTION.replace("{async}", "async " if is_async else "").replace("{await}", "await " if is_async else "")
    return text.replace("{next}", _NEXT_ASYNC if is_async else _NEXT)
