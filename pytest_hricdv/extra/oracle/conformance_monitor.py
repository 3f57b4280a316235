"""`ConformanceMonitor`: compares a run with an agent of the model as the oracle, and gives the verdict `MODEL`.

`OracleExecution` makes one for each run; it executes the agent in a `Product`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial

from pytest_hricdv.bdi import BdiError
from pytest_hricdv.coupling.events import Bindings, EventOccurrence, EventPattern, Events
from pytest_hricdv.coupling.percept_mapping import CouplingError
from pytest_hricdv.declarations.model_oracle import MODEL, ModelOracleError
from pytest_hricdv.extra.oracle.oracle import Oracle
from pytest_hricdv.extra.oracle.product import NOTHING, ModelDeviation, ModelPercept, ObservedEvent, Product
from pytest_hricdv.monitor import Trigger, Value, Verdict, Violation


class ConformanceMonitor:
    """Listens to a run, as the monitors of requirements do.

    If an input comes just before a time-out of the agent, the time-out of the code under test may come first; both is
    right. So if a run deviates after such a race, the agent is run again with the input after the time-out. If the run
    then conforms, this order is kept. The last two races are tried.

    Args:
        parameters: the run's parameters, by name.
    """

    def __init__(self, oracle: Oracle, parameters: Mapping[str, float]) -> None:
        self._oracle = oracle
        limits = oracle.declaration.limits
        self._limits = {name: parameters[limit] if isinstance(limit, str) else limit for name, limit in limits.items()}
        self._declared: list[tuple[str, int, EventPattern]] = [
            *(("heard", number, event) for number, event in enumerate(oracle.percepts)),
            *(("does", number, event) for number, event in enumerate(oracle.actions)),
            *(("fails", number, event) for number, event in oracle.fails.items()),
            *((("until", 0, oracle.until),) if oracle.until is not None else ()),
        ]
        events = [event for _, _, event in self._declared]
        names = (name for event in events for name in event.sources.values())
        self._events = Events((event.condition for event in events), names)
        self._log: list[ObservedEvent] = []
        self._delayed: frozenset[int] = frozenset()
        self._product = Product(oracle, self._limits)
        self._left_s: float | None = None
        """When the run left the model's knowledge."""
        self._doubted: ModelDeviation | None = None
        """The last deviation that was none for an agent that heard an input later."""
        self._error: BdiError | CouplingError | None = None
        """Raised at the end, not when it occurs: then it would look like an error of the running node."""

    def message(self, time_s: float, topic: str, fields: Mapping[str, Value]) -> None:
        """A message has arrived, as for a `MonitorSet`."""
        if topic in self._events.topics and not self._end:
            self._observe(self._events.message(time_s, topic, fields))

    def signal(self, time_s: float, name: str, value: Value) -> None:
        """A signal has a new value, as for a `MonitorSet`."""
        if name in self._events.signals and not self._end:
            self._observe(self._events.signal(time_s, name, value))

    def finish(self, time_s: float) -> Verdict:
        """The run ended at `time_s` (s): the verdict.

        Raises:
            ModelOracleError: the agent could not continue, or a value that it hears is not known yet.
        """
        self._observe(self._events.advance(time_s))
        if not self._end:
            self._go_on(partial(Product.finish, time_s=time_s))
        if self._error is not None:
            raise ModelOracleError(f"ModelOracle: {self._error}") from self._error
        return self._verdict(time_s if self._left_s is None else self._left_s)

    @property
    def _end(self) -> bool:
        return self._product.deviation is not None or self._error is not None or self._left_s is not None

    def _observe(self, occurrences: Iterable[EventOccurrence]) -> None:
        for occurrence in occurrences:
            if self._end:
                continue
            if any(self._declared[index][0] == "until" for index in occurrence.numbers):
                self._left_s = occurrence.time_s
                self._go_on(partial(Product.finish, time_s=occurrence.time_s))
                continue
            try:
                event = self._observe_event(occurrence)
            except CouplingError as error:
                self._error = error
                continue
            self._go_on(partial(Product.step, event=event))
            self._log.append(event)

    def _go_on(self, step: Callable[[Product], None]) -> None:
        """Take a step; where it deviates, with an agent that heard an input after its time-out, if that conforms."""
        try:
            step(self._product)
            deviation = self._product.deviation
            if deviation is None:
                return
            for number in reversed(self._product.races[-2:]):
                product = Product(self._oracle, self._limits, self._delayed | {number})
                for event in self._log:
                    product.step(event)
                step(product)
                if product.deviation is None:
                    self._product, self._delayed, self._doubted = product, self._delayed | {number}, deviation
                    return
        except BdiError as error:
            self._error = error

    def _observe_event(self, occurrence: EventOccurrence) -> ObservedEvent:
        heard: list[ModelPercept] = []
        does: dict[int, Bindings] = {}
        fails: dict[int, Bindings] = {}
        for index in occurrence.numbers:
            kind, number, event = self._declared[index]
            bindings = event.bindings(self._events.values)
            if kind == "heard":
                declared = self._oracle.declaration.percepts[number]
                heard.append(ModelPercept(event.literal(bindings), declared.source, declared.is_goal))
            else:
                (does if kind == "does" else fails)[number] = bindings
        return ObservedEvent(occurrence.time_s, occurrence.name, occurrence.text, tuple(heard), does, fails)

    def _deviation(self) -> ModelDeviation | None:
        """The deviation: the doubted one, if a second one has come of the doubt."""
        deviation, doubted = self._product.deviation, self._doubted
        # The input was delayed by the tolerance, and what follows from it may come as much too late.
        soon_s = 2 * self._oracle.declaration.tolerance_s
        return doubted if deviation and doubted and deviation.time_s - doubted.time_s <= soon_s else deviation

    def _verdict(self, time_s: float) -> Verdict:
        product = self._product
        triggers, deviation = product.triggers, self._deviation()
        open_acts = product.follower.agent.ready_acts
        history = [*triggers]
        if deviation is None:
            history += (Trigger(act.ready_s, time_s, "pending") for act in open_acts)
        else:
            history.append(Trigger(deviation.since_s, deviation.time_s, "failed"))
        return Verdict(
            requirement=MODEL,
            verdict="Failed" if deviation else "Passed" if triggers else "NC",
            triggers=len(history),
            passes=len(triggers),
            failures=int(deviation is not None),
            untriggered=int(not history),
            pending=0 if deviation else len(open_acts),
            violations=() if deviation is None else (_violation(deviation),),
            signature=() if deviation is None else _signature(deviation),
            margin=None,
            margin_time_s=None,
            history=tuple(sorted(history, key=lambda trigger: trigger.begin_s)),
        )


def _violation(deviation: ModelDeviation) -> Violation:
    text = f"expected {deviation.expected}; observed {deviation.observed}"
    return Violation(deviation.since_s, deviation.time_s, {}, None, text=text)


def _signature(deviation: ModelDeviation) -> tuple[str, ...]:
    return (f"expected {' or '.join(deviation.acts) or NOTHING}", f"observed {deviation.event}")
