"""Queues and streams of a drafted `ports.py`, as text: inboxes, outboxes, lines."""

SYNC_QUEUES = '''

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

    recv = receive = take = get

    def wait(self, timeout: float | None = None) -> Any:
        """The oldest message; None where there is none in this time."""
        try:
            return self.get(timeout=timeout)
        except queue.Empty:
            return None

    def poll(self) -> Any:
        """The oldest message; None where there is none."""
        return self._next.pop(0) if self._look() else None

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

ASYNC_QUEUES = '''

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

OUTBOX = '''

class Outbox:
    """A queue, or a function, that the code hands messages to: the robot says them."""

    def __init__(self, run: Run{kinds}) -> None:
        self._port = run.bus.port("robot"){remember}

    def __call__(self, *arguments: Any) -> None:
        """Say it. TODO: what is of none of these classes is not said: which message is it?"""
        message = {message}
        if is_message(message):
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

SCRIPT = '''

class Typed:
    """Standard input, at which a person types lines."""

    def __init__(self, inbox: Inbox) -> None:
        self._inbox = inbox

    def readline(self, *_: Any) -> str:
        """The next line."""
        return f"{self._inbox.get()}\\n"

    def __iter__(self) -> Iterator[str]:
        while True:
            yield self.readline()


def run_script(name: str, names: dict[str, Any]) -> None:
    """Execute a module of the code as a main program, with these functions in the place of Python's own."""
    spec = find_spec(name)
    if spec is None or spec.loader is None:
        raise ImportError(f"no module {name}")
    module = module_from_spec(spec)
    module.__dict__.update(names)
    tree = ast.parse(Path(spec.origin or "").read_bytes())
    for number, statement in reversed([*enumerate(tree.body)]):
        if isinstance(statement, ast.If) and "__name__" in ast.unparse(statement.test):
            tree.body[number : number + 1] = statement.body  # as its main program
    sys.modules[name], before = module, sys.stdin
    sys.stdin = Typed(names["stdin"]) if "stdin" in names else before  # type: ignore[assignment]
    try:
        exec(compile(tree, spec.origin or "", "exec"), module.__dict__)
    except SystemExit:
        return
    finally:
        sys.stdin = before
'''

STREAM = '''

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

READLINE = """try:
            line: bytes = self._inbox.get(timeout=READ_S)
        except queue.Empty:
            return b""
        return line"""
