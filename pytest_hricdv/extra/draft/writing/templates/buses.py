"""Buses of a drafted `ports.py`, as text: of an event loop, with callbacks, with topics that are texts."""

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

CALLBACK_BUS = '''

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


INBOX_BUS = '''

class Bus:
    """What the code's bus does, on the bus of the test: it has an inbox for each subscription."""

    def __init__(self, run: Run) -> None:
        self._run, self._port = run, run.bus.port("robot")

    def publish(self, *contents: Any, **_: Any) -> None:
        """Say the message among what it is called with."""
        for message in contents[:2]:
            if is_message(message):
                self._port.publish(message)

    def subscribe(self, *kinds: Any, **_: Any) -> Inbox:
        """An inbox for messages of these classes."""
        return Inbox(self._run, *(kind for kind in kinds if isinstance(kind, type)))
{aliases}'''


TOPIC_BUS = '''

class Bus:
    """What the code's bus does, on the bus of the test: topics are texts, and it calls back."""

    def __init__(self, run: Run) -> None:
        self._run, self._port = run, run.bus.port("robot")

    {async}def publish(self, topic: Any, *contents: Any, **named: Any) -> None:
        """Say what goes with a topic: an argument, or other keywords, each of which is a field."""
        contents += tuple(named[name] for name in PAYLOADS if name in named)
        own = {name: content for name, content in named.items() if name not in OPTIONS}
        said = next((one for one in (topic, *contents[:1]) if is_message(one)), None)
        kinds = SAID.get(topic, ()) if isinstance(topic, str) else ()
        is_tuple = len(contents) > 1 and any(kind.FORM == "tuple" for kind in kinds)
        content = contents if is_tuple else contents[0] if contents else own or ""
        said = of_plain(content, kinds) if said is None else said
        if said is not None:
            self._port.publish(said)

    {async_subscribe}def subscribe(self, topic: Any, callback: Callable[..., Any] | None = None, *_: Any) -> Any:
        """Call back for each message of the topic; without a callback, an inbox for them."""
        kinds = HEARD.get(topic, ()) if isinstance(topic, str) else (topic,)
        if callback is None:
            return Inbox(self._run, *kinds)
        parameters = signature(callback).parameters.values()
        names = [part.name for part in parameters if part.kind not in (part.VAR_POSITIONAL, part.VAR_KEYWORD)]
        first = (topic,) if names and names[0].strip("_") in SENDERS else ()
        has_fields = any(part.kind == part.VAR_KEYWORD for part in parameters) or (len(names) > 1 and not first)

        def call(content: Any) -> Any:
            if has_fields and isinstance(content, dict):
                return callback(*first, **content)
            return callback(*(topic, content)[2 - min(len(parameters), 2) :])

{hearing}
        return None
{aliases}'''

HEARING = """        def hear(heard: Any) -> None:
            while True:
                message = heard.wait(REST_OF_RUN_S)
                if message is not None:
                    call(to_plain(message))

        for kind in kinds:
            heard = self._port.subscribe(kind)
            self._run.kernel.spawn(f"robot hears {kind.__name__}", self._run.measured(partial(hear, heard)))"""

ASYNC_HEARING = """        async def hear(inbox: Inbox) -> None:
            while True:
                made = call(await inbox.get())
                if asyncio.iscoroutine(made):
                    await made

        self._hearing = [*getattr(self, "_hearing", ()), asyncio.ensure_future(hear(Inbox(self._run, *kinds)))]"""
