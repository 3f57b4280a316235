"""`Driver` of drafted testbenches: makes the robot with its stand-ins, runs it, and lets a person act on it."""

from __future__ import annotations

import asyncio
import inspect
import sys
from collections.abc import Callable, Mapping
from contextlib import chdir, nullcontext, suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from pytest_hricdv.extra.draft.code.naming import word
from pytest_hricdv.extra.draft.observe.tracer import state_text
from pytest_hricdv.extra.draft.stand_ins.border import RunBorder, signal_name
from pytest_hricdv.extra.draft.stand_ins.neutral import REST_OF_RUN_S
from pytest_hricdv.extra.draft.stand_ins.parts import cross_border
from pytest_hricdv.extra.draft.stand_ins.ports import Replace
from pytest_hricdv.extra.draft.stand_ins.visit import LOOKS_EACH_S, CallbackCall, Manners, MethodCall, Say, Visit
from pytest_hricdv.runtime import text_of, topic_of
from pytest_hricdv.runtime.virtual.threads import active_count
from pytest_hricdv.testbench import Outcome, Run

__tracebackhide__ = True  # a failing test shows the frames of the code; pytest's --full-trace shows these, too


@dataclass(frozen=True)
class Driver:
    """Runs code as the robot of a testbench; give `driver.run`, `driver.messages` and `driver.signals` to it.

    Args:
        robot: a class or function of the code.
        ports: what it is called with: a stand-in for each parameter.
        method: the method of the object, which makes the robot work; empty if the code is only called.
        method_ports: what the method is called with.
        period_s: the method is called again and again with this period, as a control loop; 0: once.
        says: command -> what a person says by it.
        reaches: class of a message -> the method or callback by which it gets to the robot; others are on its bus.
        answers: classes of messages by which the robot answers.
        outputs: all classes of messages that the robot publishes.
        called: "port.method", or "port.method topic" -> class of the message that says that the robot has called it.
        senses: "port.name" -> what a device returns first; a person sets it.
        settings: command -> the text that it sets, of a device that returns texts.
        inner: name -> stand-in of an object that the code makes itself.
        state: path of the attribute that holds the robot's state, as "mode" or "machine.state"; empty if it
            publishes its state itself.
        state_message: class of the message that says that it has changed.
        state_field: its field with the state.
        person: name of the person.
        manners: how the person waits.
        limit_s: no run takes longer (s of simulated time).
        takes_s: simulated time that each call of a device takes, or a hundred polls of events, queues and clocks.
        may_end: whether the robot may end before the person leaves.
        may_raise: errors at which the robot ends, as it lacks a file, a connection or a module.
        cross: name of the cross product of the state with the manner of what was said; empty for none.
        is_async: whether the robot is a coroutine.
        folder: the working folder of a run, whose files the code reads; None leaves it.
    """

    robot: Callable[..., Any]
    ports: Mapping[str, Any] = field(default_factory=dict)
    method: str = ""
    method_ports: Mapping[str, Any] = field(default_factory=dict)
    period_s: float = 0.0
    says: Mapping[str, Say] = field(default_factory=dict)
    reaches: Mapping[type[Any], MethodCall | CallbackCall] = field(default_factory=dict)
    answers: tuple[type[Any], ...] = ()
    outputs: tuple[type[Any], ...] = ()
    called: Mapping[str, type[Any]] = field(default_factory=dict)
    senses: Mapping[str, Any] = field(default_factory=dict)
    settings: Mapping[str, str] = field(default_factory=dict)
    inner: Mapping[str, Replace] = field(default_factory=dict)
    state: str = ""
    state_message: type[Any] | None = None
    state_field: str = "state"
    person: str = "person"
    manners: Manners = field(default_factory=Manners)
    limit_s: float = 900.0
    takes_s: float = 0.0
    may_end: bool = False
    may_raise: tuple[type[Exception], ...] = ()
    cross: str = ""
    is_async: bool = False
    folder: Path | None = None

    @property
    def messages(self) -> tuple[type[Any], ...]:
        """All classes of messages, for `Testbench.messages`."""
        said = (say.kind for say in self.says.values())
        changed = (self.state_message,) if self.state_message is not None and self.state else ()
        every = dict.fromkeys((*said, *self.reaches, *self.outputs, *changed, *self.called.values()))
        return tuple(sorted(every, key=lambda kind: kind.__name__))

    @property
    def signals(self) -> dict[str, type[bool | float | str]]:
        """The recorded signals, for `Testbench.signals`: return values of devices, and who is present."""
        senses = {signal_name(name): type(value) for name, value in self.senses.items()}
        return {**senses, "person_is_there": bool, "robot_works": bool}

    def run(self, run: Run) -> Outcome:
        """One run of one test, for `Testbench.run`."""
        run.kernel.polls_take_s = 0.0 if self.is_async else self.takes_s
        border = RunBorder(run, frozenset(self.messages), self.called, dict(self.senses), self.takes_s, self.is_async)
        for name, value in self.senses.items():
            border.record(signal_name(name), value)
        for name in ("person_is_there", "robot_works"):
            border.record(name, True)
        bus = run.bus.port(self.person)
        answers = [bus.subscribe(kind) for kind in self.answers]
        heard = [bus.subscribe(kind) for kind in (*self.outputs, *self.called.values())]
        visit = Visit(run, self.says, lambda say, numbers: bus.publish(say.message(numbers)), answers, heard,
                      self.manners, self._settings(), border.sense)  # fmt: skip
        active = ActiveRobot(self, border, visit)
        run.kernel.spawn(self.person, visit.act)
        run.kernel.spawn("robot", run.measured(active.work))  # coverage is measured in here
        for kind, how in self.reaches.items():
            heard_here = run.bus.port("robot").subscribe(kind)
            run.kernel.spawn(f"robot hears {topic_of(kind)}", run.measured(partial(active.hear, heard_here, how)))
        undo = [replace.apply(border, name) for name, replace in self.inner.items()]
        try:
            with cross_border(border), chdir(self.folder) if self.folder is not None else nullcontext():
                ended = run.go(self.limit_s)
        finally:
            for put_back in reversed(undo):
                put_back()
            border.close()
        return Outcome(ended, cross={self.cross: active.hits} if self.cross else {})

    def _settings(self) -> dict[str, tuple[str, str | None]]:
        """Word of a command, or the command, -> what it sets, and to which text."""
        words = {f"set_{word(signal_name(name))}": (name, None) for name in self.senses}
        texts = {command: (words[command.rpartition(" ")[0]][0], text) for command, text in self.settings.items()}
        return {**words, **texts}


async def _keep_loop() -> None:
    """Wait for the rest of a run; code that cancels all tasks of the loop does not mean this one."""
    is_over = False
    while not is_over:
        with suppress(asyncio.CancelledError):
            await asyncio.sleep(REST_OF_RUN_S)
            is_over = True


class ActiveRobot:
    """The code in one run."""

    def __init__(self, driver: Driver, border: RunBorder, visit: Visit) -> None:
        self._driver, self._border, self._visit = driver, border, visit
        self._kernel = border.run.kernel
        self._waiting: list[Callable[[], Any]] = []
        self._loop: asyncio.AbstractEventLoop | None = None
        self._state: str | None = None
        self._is_looking = False
        self.hits: list[tuple[str, str]] = []
        border.on_crossing, border.on_said = self.look, self.note

    def work(self) -> None:
        """The body of the robot's node."""
        threads = active_count()
        with suppress(*self._driver.may_raise):
            if self._driver.is_async:
                asyncio.run(self._work_async())
            else:
                self._work()
        if active_count() > threads or (self._driver.reaches and not self._driver.may_end):
            self._kernel.sleep(REST_OF_RUN_S)  # its threads work on, or it is only called
        self._border.record("robot_works", False)
        if self._driver.may_end:
            self._kernel.stop("the robot has ended its work")

    def _make(self) -> Any:
        made = self._driver.robot(**self._arguments(self._driver.ports))
        if inspect.isclass(self._driver.robot):
            self._border.instance = made
            self._watch(made)
        return made

    def _arguments(self, ports: Mapping[str, Any]) -> dict[str, Any]:
        return {name: port.make(self._border, name) if hasattr(port, "make") else port for name, port in ports.items()}

    def _work(self) -> None:
        made = self._make()
        driver = self._driver
        if not inspect.isclass(driver.robot):
            self._exhaust(made)
        elif driver.period_s:
            arguments = self._arguments(driver.method_ports)  # what comes in between two steps is for the next one
            while True:
                self._call_waiting()
                getattr(made, driver.method)(**arguments)
                self.look()
                self._kernel.sleep(driver.period_s)
        elif driver.method:
            self._exhaust(getattr(made, driver.method)(**self._arguments(driver.method_ports)))
        else:
            self._kernel.sleep(REST_OF_RUN_S)  # it is called back

    def _exhaust(self, result: Any) -> None:
        """A generator is run to its end, with a little time between its steps."""
        if inspect.isgenerator(result):
            for _ in result:
                self.look()
                self._kernel.sleep(LOOKS_EACH_S)

    async def _work_async(self) -> None:
        self._loop = asyncio.get_running_loop()
        made = self._make()
        if inspect.isclass(self._driver.robot):
            if not self._driver.method:
                await _keep_loop()
                return
            made = getattr(made, self._driver.method)(**self._arguments(self._driver.method_ports))
        if inspect.isawaitable(made):
            await made

    # --- what gets to it by calls

    def hear(self, heard: Any, how: MethodCall | CallbackCall) -> None:
        """The body of a node that calls the code for each message of a class."""
        while True:
            functions = self._functions(how)
            if not functions:
                self._kernel.sleep(LOOKS_EACH_S)
                continue
            message = heard.wait(REST_OF_RUN_S)
            for function in self._functions(how) if message is not None else ():
                self._call(partial(self._answer, function, how, message))

    def _answer(self, function: Callable[..., Any], how: MethodCall | CallbackCall, message: Any) -> Any:
        """Call a function with a message; tell what it returns."""
        made = function(*how.arguments(message))
        name = getattr(function, "__name__", "")
        if inspect.iscoroutine(made):
            return self._answer_later(made, name)
        self._border.tell_answer(name, made)
        return made

    async def _answer_later(self, made: Any, name: str) -> None:
        self._border.tell_answer(name, await made)

    def _functions(self, how: MethodCall | CallbackCall) -> list[Callable[..., Any]]:
        if isinstance(how, CallbackCall):
            return list(dict.fromkeys(self._border.callbacks.get(how.port, ())))
        if ":" in how.method:
            module, _, name = how.method.partition(":")
            function = getattr(sys.modules.get(module), name, None)  # a program defines it while it runs
            return [function] if function is not None else []
        return [getattr(self._border.instance, how.method)] if self._border.instance is not None else []

    def _call(self, call: Callable[[], Any]) -> None:
        """Call at once; in an event loop, or between two steps of a control loop, if the code has one."""
        if self._loop is not None:
            self._loop.call_soon_threadsafe(self._call_in_loop, call)
        elif self._driver.period_s:
            self._waiting.append(call)
        else:
            self._exhaust(call())
            self.look()

    def _call_waiting(self) -> None:
        while self._waiting:
            self._exhaust(self._waiting.pop(0)())
            self.look()

    def _call_in_loop(self, call: Callable[[], Any]) -> None:
        result = call()
        if inspect.iscoroutine(result):
            self._task = asyncio.ensure_future(result)

    # --- its state

    def _watch(self, made: Any) -> None:
        """Look at the state whenever an attribute of the object that has it is set."""
        owner = made
        for name in self._driver.state.split(".")[:-1]:
            owner = getattr(owner, name, None)
        kind: Any = type(owner)
        look = self.look

        def set_and_look(this: Any, name: str, value: Any) -> None:
            kind.__setattr__(this, name, value)
            look()

        # A class that registers its subclasses would register the one made here.
        hears = any("__init_subclass__" in vars(base) for base in kind.__mro__[:-1])
        if self._driver.state and not hears:
            try:
                named = {name: getattr(kind, name) for name in ("__module__", "__qualname__")}
                owner.__class__ = type(kind.__name__, (kind,), {"__setattr__": set_and_look, "__slots__": (), **named})
            except TypeError:
                return  # its class cannot be changed: it is looked at when the code calls something
        self.look()

    def note(self, message: Any) -> None:
        """Note in which state the code says that it is."""
        if not self._driver.state and type(message) is self._driver.state_message:
            value = getattr(message, self._driver.state_field)
            self.hits.append((value if isinstance(value, str) else text_of(value), self._visit.manner))

    def look(self) -> None:
        """Publish the state if it has changed; what is looked at may be a stand-in, whose use is seen, too."""
        if self._is_looking:
            return
        self._is_looking = True
        try:
            self._look()
        finally:
            self._is_looking = False

    def _look(self) -> None:
        self._border.note_states()
        if not self._driver.state or self._border.instance is None or self._driver.state_message is None:
            return
        value = self._border.instance
        for name in self._driver.state.split("."):
            value = getattr(value, name, None)
        state = state_text(value)
        if state is not None and state != self._state:
            self._state = state
            self.hits.append((state, self._visit.manner))
            self._border.run.bus.publish("robot", self._driver.state_message(state=state))
