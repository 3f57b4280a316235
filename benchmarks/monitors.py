"""Cost of monitoring a run: the monitors, the search for nearest misses, and rtamt on the same run; then that of an
event, by its rate and the length of windows, beside rtamt's.

    python -m benchmarks.monitors [--repeat N]

The run has 150 s at 240 Hz: 36,000 instants, at each of which three signals change, and a reading every second. R1 to
R4 of the table assembly are checked. Run it on an otherwise idle machine; lines with rtamt need the dependency group
`test`.
"""

from __future__ import annotations

import argparse
import math
import statistics
import sys
import time
from array import array
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import cast

from benchmarks.monitor_windows import show_windows
from pytest_hricdv.monitor import Log, MonitorSet, Requirement, Vocabulary, evaluate, load_requirements
from pytest_hricdv.monitor.antecedent import near_miss
from studies.session import machine

# A long test of the case study (up to 175 s), at twice the rate of physics: 36,000 updates, as rtamt is measured with.
RATE_HZ = 240
DURATION_S = 150
REQUIREMENTS = Path(__file__).parents[1] / "tests" / "monitor" / "case_study.toml"
VOCABULARY = Vocabulary(
    signals={"leg_held": bool, "leg_torn": bool, "leg_offset": float, "hand_closing": bool}
    | dict.fromkeys(("hand_distance", "hand_contact_force", "arm_speed"), float),
    messages={
        "reading": {"gaze": bool, "pressure": bool, "location": bool},
        "request": {},
        "signal": {},
        "ready": {},
        "table_done": {"released": float, "duration_s": float, "on_time": bool},
    },
)
# The four requirements in rtamt's words, a tick being a step: a hysteresis only merges violations of one trigger.
READY = "(reading > 0) and (gaze > 0) and (pressure > 0) and (location > 0)"
NOT_READY = "(reading > 0) and not((gaze > 0) and (pressure > 0) and (location > 0))"
RELEASED = "(fall(leg_held > 0) and not(leg_torn > 0) and (leg_offset < 0.15))"
RTAMT = {
    "R1": f"({READY}) implies eventually[0:{10 * RATE_HZ}]({RELEASED})",
    "R2": f"({NOT_READY}) implies (always(not {RELEASED}) or ((not {RELEASED} or (request > 0)) until (request > 0)))",
    "R3": "(hand_closing > 0) implies (hand_distance >= 0.05)",
    "R4": "(arm_speed > 0.001) implies (arm_speed < 0.25)",
}


@dataclass(frozen=True)
class Message:
    """A message of the log."""

    time_s: float
    topic: str
    fields: dict[str, bool]


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeat", type=int, default=5, metavar="N", help="runs of each measurement (default 5)")
    repeat = parser.parse_args().repeat
    requirements = tuple(rule for rule in load_requirements(REQUIREMENTS, VOCABULARY) if rule.id in RTAMT)
    log = made_up()
    print(f"machine: {machine()}\nmedians of {repeat}; {RATE_HZ * DURATION_S} instants, four requirements\n")
    fed = events(log)
    monitored = show("monitors that are fed events", repeat, lambda: watch(requirements, fed, log.end_s))
    logged = show(
        "monitors that are fed the log", repeat, lambda: [verdict.verdict for verdict in evaluate(requirements, log)]
    )
    for requirement in requirements:
        show(f"nearest miss of {requirement.id}", repeat, partial(explain, requirement, log))
    try:
        oracle = show("rtamt over the log", min(repeat, 3), rtamt_over(log))
    except ImportError:
        oracle = monitored
        print("rtamt is not installed")
    print("\nverdicts:", ", ".join(monitored))
    if not monitored == logged == oracle:
        sys.exit(f"the verdicts differ: {monitored}, {logged}, {oracle}")
    print()
    show_windows()


def made_up() -> Log:
    """A run in which R1 and R2 are checked, R3 holds, and R4 fails in the end."""
    steps = [step / RATE_HZ for step in range(RATE_HZ * DURATION_S)]
    dense: dict[str, Callable[[float], float]] = {
        "leg_offset": lambda t: 0.1 + 0.05 * math.sin(t) ** 2 * (t % 20 > 10),
        "hand_distance": lambda t: 0.3 + 0.2 * math.sin(3 * t),
        "arm_speed": lambda t: 0.24 * abs(math.sin(0.7 * t)) + 0.02 * (t > 149),
    }
    signals = {name: (array("d", steps), array("d", map(value, steps))) for name, value in dense.items()}
    signals["hand_closing"] = (array("d", range(0, DURATION_S, 5)), array("d", [0.0, 1.0] * (DURATION_S // 10)))
    signals["leg_held"] = (array("d", range(0, DURATION_S, 10)), array("d", [1.0, 0.0, 1.0] * (DURATION_S // 30)))
    signals["leg_torn"] = (array("d", [0.0]), array("d", [0.0]))
    signals["hand_contact_force"] = (array("d", [0.0]), array("d", [0.0]))
    messages: list[Message] = []
    for second in range(DURATION_S):
        at_s = second + 0.5
        if second % 10 == 2:
            messages.append(Message(at_s, "request", {}))
        ready = second % 30 in (3, 4, 5)
        messages.append(Message(at_s, "reading", {"gaze": True, "pressure": ready, "location": True}))
    return Log(signals, messages, float(DURATION_S))


def series(log: Log) -> Mapping[str, tuple[Sequence[float], Sequence[float]]]:
    """The signals of the log, none of which is a text."""
    return cast("Mapping[str, tuple[Sequence[float], Sequence[float]]]", log.signals)


def events(log: Log) -> list[tuple[float, str, float | bool | dict[str, bool]]]:
    """The run as it would be fed, in the order of time."""
    fed: list[tuple[float, str, float | bool | dict[str, bool]]] = [
        (time_s, name, bool(value) if VOCABULARY.signals[name] is bool else value)
        for name, (times, values) in series(log).items()
        for time_s, value in zip(times, values, strict=True)
    ]
    fed += [(message.time_s, message.topic, dict(message.fields)) for message in log.messages]  # type: ignore[arg-type]
    return sorted(fed, key=lambda event: event[0])


def watch(
    requirements: tuple[Requirement, ...], fed: list[tuple[float, str, float | bool | dict[str, bool]]], end_s: float
) -> list[str]:
    """Feed the monitors."""
    monitors = MonitorSet(requirements)
    for time_s, name, value in fed:
        if isinstance(value, dict):
            monitors.message(time_s, name, value)
        else:
            monitors.signal(time_s, name, value)
    return [verdict.verdict for verdict in monitors.finish(end_s)]


def explain(requirement: Requirement, log: Log) -> list[str]:
    """Look for the nearest miss, whether or not there was one: the cost is the same."""
    return list(near_miss(requirement.formula.antecedent, log).missing)


def rtamt_over(log: Log) -> Callable[[], list[str]]:
    """The same with rtamt, parsed and sampled beforehand. Raises ImportError where there is no rtamt."""
    import rtamt  # type: ignore[import-untyped]

    samples = sampled(log)
    specifications = []
    for text in RTAMT.values():
        specification = rtamt.StlDiscreteTimeSpecification()
        for name in samples:
            specification.declare_var(name, "float")
        specification.spec = text
        specification.parse()
        specifications.append(specification)

    def judged() -> list[str]:
        values = (min(value for _, value in specification.evaluate(samples)) for specification in specifications)
        return ["Failed" if value < 0 else "Passed" for value in values]

    return judged


def sampled(log: Log) -> dict[str, list[float]]:
    """One value a step; what is true or arrives is 1, else -1."""
    count = RATE_HZ * DURATION_S
    samples: dict[str, list[float]] = {"time": [float(step) for step in range(count)]}
    for name, (times, values) in series(log).items():
        scaled = [2 * value - 1 for value in values] if VOCABULARY.signals[name] is bool else list(values)
        samples[name] = held([(time_s, value) for time_s, value in zip(times, scaled, strict=True)])
    for topic, fields in VOCABULARY.messages.items():
        heard = [message for message in log.messages if message.topic == topic]
        arrived = {step_of(message.time_s) for message in heard}
        samples[topic] = [1.0 if step in arrived else -1.0 for step in range(count)]
        for field in fields:
            samples[field] = held(
                [(0.0, -1.0), *((message.time_s, 1.0 if message.fields[field] else -1.0) for message in heard)]
            )
    return samples


def held(changes: list[tuple[float, float]]) -> list[float]:
    """The last value at each step."""
    samples: list[float] = []
    for (time_s, value), (until_s, _) in zip(changes, [*changes[1:], (DURATION_S, 0.0)], strict=True):
        samples += [value] * (step_of(until_s) - step_of(time_s))
    return samples


def step_of(time_s: float) -> int:
    """The step at a time."""
    return round(time_s * RATE_HZ)


def show(label: str, repeat: int, action: Callable[[], list[str]]) -> list[str]:
    """Print the median wall time of an action; returns its result."""
    times = []
    for _ in range(repeat):
        began = time.perf_counter()
        result = action()
        times.append(time.perf_counter() - began)
    print(f"{label:40} {statistics.median(times) * 1e3:10.1f} ms", flush=True)
    return result


if __name__ == "__main__":
    main()
