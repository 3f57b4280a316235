"""What an event costs the monitors, by its rate and by the length of windows; part of `benchmarks.monitors`.

Every window is full when the measurement begins, so that at 1,000 Hz and 600 s up to 600,000 triggers are open. A cost
is the least of several blocks of events, which a busy machine disturbs least; where something is met once in a window,
a block is as long as that.
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable
from dataclasses import dataclass

from pytest_hricdv.monitor import MonitorSet, Requirement, Vocabulary, parse_formula

RATES_HZ = (1, 50, 1000)
WINDOWS_S = (1, 60, 600)

BLOCK = 2000  # events; chosen: some 20 ms, so that a pause of a busy machine spoils only one block
LEAST_BLOCKS = 3
LEAST_EVENTS = 50 * BLOCK

FEWEST_IN_WINDOW = 10
"""Events in a window in which something is met once; chosen: with fewer, the changes by which it is are what costs."""

MET_AFTER = 0.9
"""Part of a window after which what is expected comes; chosen: so that most of a window has been open by then."""

RTAMT_S = 1.0
"""How long rtamt is measured for (s), at least one update: it goes through the whole window, so it may take seconds."""

VOCABULARY = Vocabulary(signals={"held": bool, "level": float}, messages={"reading": {"value": float}})


@dataclass(frozen=True)
class Form:
    """A kind of requirement; in its text, W is the length of the window (s) and E the end of one that is half the time
    between two events longer (s).

    Args:
        label: for people.
        text: of the formula.
        is_met: whether `held` becomes true once in a window.
        rtamt: the same in rtamt's words, for one sample an event: N is the number of events in a window.
    """

    label: str
    text: str
    is_met: bool = False
    rtamt: str = ""


FORMS = (
    Form(
        "eventually, never met",
        "always(on(reading) -> eventually[0:W](held))",
        rtamt="(reading > 0) implies eventually[0:N](held > 0)",
    ),
    Form("eventually, met", "always(on(reading) -> eventually[0:W](held))", is_met=True),
    Form(
        "always",
        "always(on(reading) -> always[0:W](level < 1))",
        rtamt="(reading > 0) implies always[0:N](level < 1)",
    ),
    Form("until", "always(on(reading) -> always(level < 1) until held)", is_met=True),
    Form("since", "always(on(reading) -> level < 1 since on(reading))"),
    Form(
        "once",
        "always(on(reading) -> once[0:W](held) | level < 1)",
        rtamt="(reading > 0) implies (once[0:N](held > 0) or (level < 1))",
    ),
    Form("once, long ago", "always(on(reading) -> once[W:E](on(reading)))"),
    Form("historically", "always(on(reading) -> historically[W:E](reading.value < 1))"),
    Form("count", "always(on(reading) -> count[0:W](on(reading)) >= 0)"),
)


def show_windows() -> None:
    """Measure and print: a line a form, a column for each rate and window."""
    cells = [(rate_hz, window_s) for rate_hz in RATES_HZ for window_s in WINDOWS_S]
    print("us an event, at a rate (Hz) and with windows of so many seconds; all windows are full:")
    print(f"{'':30}" + "".join(f"{f'{rate}/{window_s}':>10}" for rate, window_s in cells) + "   largest/smallest")
    for form in FORMS:
        _show(form.label, [cost_us(form, *cell) if _is_measured(form, *cell) else math.nan for cell in cells])
    for form in FORMS:
        if form.rtamt:
            try:
                _show(f"rtamt, {form.label}", [rtamt_us(form, *cell) for cell in cells])
            except ImportError:
                print("rtamt is not installed")
                return


def _show(label: str, costs_us: list[float]) -> None:
    figures = "".join(f"{cost:10.1f}" if cost < 1000 else f"{cost:10.0f}" for cost in costs_us).replace("nan", "  -")
    measured = [cost for cost in costs_us if not math.isnan(cost)]
    print(f"{label:30}{figures}   {max(measured) / min(measured):.2f}", flush=True)


def _is_measured(form: Form, rate_hz: int, window_s: int) -> bool:
    return not form.is_met or rate_hz * window_s >= FEWEST_IN_WINDOW


def cost_us(form: Form, rate_hz: int, window_s: int) -> float:
    """The CPU time of an event (us) once all windows are full."""
    text = form.text.replace("W", str(window_s)).replace("E", repr(window_s + 0.5 / rate_hz))
    monitors = MonitorSet([Requirement("R1", "", "", text, parse_formula(text, VOCABULARY))])
    monitors.signal(0.0, "held", False)
    monitors.signal(0.0, "level", 0.0)
    period = max(1, round(MET_AFTER * window_s * rate_hz)) if form.is_met else 0
    numbers = itertools.count(1)

    def feed(count: int) -> float:
        began_s = time.process_time()
        for number in itertools.islice(numbers, count):
            time_s = number / rate_hz
            monitors.message(time_s, "reading", {"value": 0.0})
            if period and number % period == 0:  # at an instant between two events
                monitors.signal(time_s + 0.25 / rate_hz, "held", True)
                monitors.signal(time_s + 0.5 / rate_hz, "held", False)
        return time.process_time() - began_s

    feed(window_s * rate_hz + 1)
    block = period * math.ceil(BLOCK / period) if period else BLOCK
    updates = block + 2 * (block // period) if period else block
    return min(feed(block) for _ in range(max(LEAST_BLOCKS, LEAST_EVENTS // block))) / updates * 1e6


def rtamt_us(form: Form, rate_hz: int, window_s: int) -> float:
    """The CPU time of rtamt for a sample (us), online; its windows are full from the start.

    Raises:
        ImportError: there is no rtamt.
    """
    import rtamt  # type: ignore[import-untyped]

    specification = rtamt.StlDiscreteTimeSpecification()
    for name in ("reading", "held", "level"):
        specification.declare_var(name, "float")
    specification.spec = form.rtamt.replace("N", str(window_s * rate_hz))
    specification.parse()
    specification.pastify()
    return _mean_us(lambda number: specification.update(number, [("reading", 1.0), ("held", -1.0), ("level", 0.0)]))


def _mean_us(update: Callable[[int], object]) -> float:
    began_s = time.process_time()
    number = 0
    while number == 0 or (time.process_time() - began_s < RTAMT_S and number < LEAST_EVENTS):
        update(number)
        number += 1
    return (time.process_time() - began_s) / number * 1e6
