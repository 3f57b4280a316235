"""Classes of a drafted `ports.py` as text: queues, buses, and stand-ins for unknown values and missing modules."""

SYNC_QUEUES = '''

class Inbox:
    """A queue that the code takes from: what a person says goes into it."""

    def __init__(self, run: Run, *kinds: type[Any]) -> None:
        self._kernel = run.kernel
        self._heard = [run.bus.port("robot").subscribe(kind) for kind in kinds]
        self._next: list[Any] = []

    def _look(self) -> bool:
        """Whether there is a message."""
        for heard in self._heard:
            message = None if self._next else heard.poll()
            if message is not None:
                self._next.append(message)
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
                    return message
            else:
                self._kernel.sleep(min(LOOKS_EACH_S, left_s))
        return self._next.pop(0)

    def get_nowait(self) -> Any:
        """The same without waiting."""
        return self.get(block=False)

    def wait(self, timeout: float | None = None) -> Any:
        """The oldest message; None where there is none in this time."""
        try:
            return self.get(timeout=timeout)
        except queue.Empty:
            return None

    def poll(self) -> Any:
        """The oldest message; None where there is none."""
        return self._next.pop(0) if self._look() else None

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

    def __init__(self, run: Run, *kinds: type[Any]) -> None:
        self._queue: asyncio.Queue[Any] = asyncio.Queue()
        self._loop = asyncio.get_running_loop()
        for kind in kinds:
            heard = run.bus.port("robot").subscribe(kind)
            run.kernel.spawn(f"robot hears {kind.__name__}", partial(self._hear, heard))

    def _hear(self, heard: Any) -> None:
        while not self._loop.is_closed():
            message = heard.wait(REST_OF_RUN_S)
            if message is not None and not self._loop.is_closed():
                self._loop.call_soon_threadsafe(self._queue.put_nowait, message)

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

    def __init__(self, run: Run) -> None:
        self._port = run.bus.port("robot")

    def __call__(self, *arguments: Any) -> None:
        """Say it. TODO: what is of none of these classes is not said: which message is it?"""
        message = arguments[-1]
        if is_message(message):
            self._port.publish(message)

    put_nowait = __call__

    {put}
        """Say it; it never waits."""
        self(message)

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

ASYNC_BUS = '''

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

SYNC_BUS = '''

class Bus:
    """What the code's bus does, on the bus of the test: it calls back, or has an inbox for each subscription."""

    def __init__(self, run: Run) -> None:
        self._run, self._port = run, run.bus.port("robot")

    def publish(self, *contents: Any, **_: Any) -> None:
        """Publish the message among the arguments."""
        for message in contents[:2]:
            if is_message(message):
                self._port.publish(message)

    def subscribe(self, *arguments: Any, **_: Any) -> Inbox:
        """An inbox for messages of these classes; a function among the arguments is called for each."""
        kinds = [kind for kind in arguments if isinstance(kind, type)]
        inbox = Inbox(self._run, *kinds)
        callback = next((one for one in arguments if callable(one) and one not in kinds), None)
        if callback is not None:  # in a node of its own, as the thread of a middleware does
            names = ", ".join(kind.__name__ for kind in kinds)
            self._run.kernel.spawn(f"robot hears {names}", self._run.measured(partial(self._call, inbox, callback)))
        return inbox

    def _call(self, inbox: Inbox, callback: Callable[[Any], Any]) -> None:
        while True:
            callback(inbox.get())
'''

ANYTHING = '''

class Anything(float):
    """A neutral value of an unknown type: 0.0, which has each attribute, can be called, and is empty."""

    def __new__(cls, *_: Any, **__: Any) -> Self:
        return float.__new__(cls)

    def __init__(self, *_: Any, **named: Any) -> None:
        self.__dict__.update(named)

    def __getattr__(self, name: str) -> Anything:
        if name.startswith("__"):
            raise AttributeError(name)
        return Anything()

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """Anything; a decorator leaves a function as it is."""
        is_decorator = len(arguments) == 1 and not named and isinstance(arguments[0], FunctionType)
        return arguments[0] if is_decorator else Anything()

    def __await__(self) -> Iterator[Any]:
        return iter(())

    def __getitem__(self, _: Any) -> Anything:
        return Anything()

    def __iter__(self) -> Iterator[Any]:
        return iter(())

    def __len__(self) -> int:
        return 0

    def __index__(self) -> int:
        return 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        return None

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        return None

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> Any:
        raise StopAsyncIteration
'''

MISSING = '''

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
