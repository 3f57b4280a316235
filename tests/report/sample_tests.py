"""Made-up tests of a report, with the figures of a plausible run."""

import random
from collections.abc import Collection
from typing import Any

import msgspec

from pytest_hricdv.results.model import TestResult

PLANS = {"human": 48, "robot_code": 12}
TITLES = {
    "R1": "If gaze, pressure and location sense the human ready, then a leg shall be released",
    "R2": "If gaze, pressure or location sense the human not ready, then a leg shall not be released",
    "R3": "The robot shall not close its hand when the human hand is too close",
    "R4": "The robot shall start and work in restricted joint speed",
}

GPL = tuple(f"{n:03b}" for n in range(8))
LEGS = ("1", "2", "3", "4")
MAP: dict[str, dict[str, Any]] = {
    "controller/journal.py": {
        "statements": [*range(1, 13), 58, 60, 61, 69, 70],
        "branches": [[58, 60], [58, 69], [69, -12], [69, 70]],
        "source": "".join(f"line({n})\n" for n in range(1, 71)),
    },
    "controller/states.py": {
        "statements": list(range(1, 279)),
        "branches": [[n, n + step] for n in range(10, 270, 6) for step in (1, 3)],
        "source": "".join(f"state({n})\n" for n in range(1, 279)),
    },
}


def result(rng: random.Random, suite: str = "rl") -> TestResult:
    """A single test."""
    return msgspec.convert(test(rng, suite), TestResult)


def test(rng: random.Random, suite: str) -> dict[str, Any]:
    """A test of one to four legs, some of them failing a requirement."""
    legs = [
        rng.choice(["released", "discarded", "no-human-ready", "sensing-timeout"]) for _ in range(rng.randint(1, 4))
    ]
    action_id = f"{suite}-leg{5 - len(legs)}-{rng.randrange(16**8):08x}"
    gpl = [(sense, rng.randint(0, 1)) for _ in legs for sense in ("gaze", "pressure", "location")]
    abstract = [
        "tell leg",
        "receivesignal",
        *(f"set_param {sense} = {value}" for sense, value in gpl),
        "tell humanReady",
    ]
    verdicts = {name: verdict(rng, name) for name in TITLES}
    failed = {name for name, result in verdicts.items() if result["verdict"] == "Failed"}
    return {
        "nodeid": f"tests/hri/test_table_assembly.py::test_table_assembly[{action_id}]",
        "suite": suite,
        "id": action_id,
        "target": "plans",
        "name": "",
        "beliefs": [f"leg{5 - len(legs)}", *(f"m{rng.randrange(8):03b}l{n}" for n in range(1, len(legs) + 1))],
        "abstract": abstract,
        "concrete": {
            "actions": [{"command": command, "parameters": {"voice_s": rng.uniform(2, 5)}} for command in abstract],
            "run": {"sensing_timeout_s": rng.uniform(10, 100)},
        },
        "seed": rng.randrange(2**31),
        "outcome": "failed" if failed - {"R3"} else "known-violation" if failed else "passed",
        "wall_s": rng.uniform(0.3, 0.9),
        "sim_s": rng.uniform(40, 300),
        "skipped_s": rng.uniform(10, 40),
        "fidelity": "",
        "end_reason": "table done",
        "unmeasured": "",
        "outcomes": legs,
        "record_sha256": f"{rng.getrandbits(256):064x}",
        "requirements": verdicts,
        "plans": {agent: [f"plan{n}" for n in range(1, total, 2)] for agent, total in PLANS.items()},
        "code": {"statements": 250, "percent": min(rng.gauss(78, 6), 100.0), "bits": _bits(rng)},
        "cross": {"handover": [[rng.choice(GPL[1:]), rng.choice(LEGS)] for _ in legs]},
        "failure": "",
        "timeline": timeline(rng, verdicts),
    }


def timeline(rng: random.Random, verdicts: dict[str, Any]) -> dict[str, Any]:
    """A run of 60 s: states, two messages, a switch, a signal, and a span for each trigger."""
    speeds = " ".join(f"{n} {rng.uniform(0, 0.24):.3g}" for n in range(0, 60, 2))
    states = [f'{n}\trobot\tstate\t{{"name":"{name}"}}' for n, name in enumerate(("Wait", "Fetch", "Offer", "Done"))]
    marks = {"Passed": ["1-2", "41.25-51.5"], "Failed": ["1-2", "41.25-51.5!"], "NC": []}
    triggers = {name: " ".join(marks[result["verdict"]]) for name, result in verdicts.items() if result["triggers"]}
    return {
        "end_s": 60.0,
        "messages": [*states, "5.5\thuman\trequest\t{}", '51.5\tsensors\treading\t{"gaze":true}'],
        "signals": {"arm_speed": speeds, "leg_held": "0 0 7.5 1 50 0"},
        "triggers": triggers,
    }


def verdict(rng: random.Random, name: str) -> dict[str, Any]:
    """A verdict: R1 mostly not checked, R3 failing now and then, R4 always passed."""
    chances = {"R1": (20, 1, 79), "R2": (70, 0, 30), "R3": (88, 10, 2), "R4": (1, 0, 0)}[name]
    return requirement_result(rng.choices(["Passed", "Failed", "NC"], chances)[0], rng.uniform(0.01, 9.0))


def requirement_result(outcome: str, margin: float) -> dict[str, Any]:
    """A verdict with its counts, and one violation where it failed."""
    violation = {"trigger_s": 41.25, "time_s": 51.5, "values": {"hand_distance": 0.03}, "margin": -0.02}
    failed = outcome == "Failed"
    miss = {"time_s": 41.25, "missing": ["reading.pressure"], "distance": None}
    return {
        "verdict": outcome,
        "triggers": 0 if outcome == "NC" else 2,
        "passes": {"NC": 0, "Failed": 1, "Passed": 2}[outcome],
        "failures": int(failed),
        "untriggered": int(outcome == "NC"),
        "pending": 0,
        "margin": None if outcome == "NC" else -0.02 if failed else margin,
        "margin_time_s": None if outcome == "NC" else 51.5,
        "near_miss": miss if outcome == "NC" else None,
        "violations": [violation] if failed else [],
    }


def requirement_results(*failed: str, unchecked: Collection[str] = (), margin: float = 8.25) -> dict[str, Any]:
    """Verdicts on all requirements: those that failed, those that were not checked, and the others, which passed."""
    verdicts = {name: "Failed" if name in failed else "NC" if name in unchecked else "Passed" for name in TITLES}
    return {name: requirement_result(verdict, margin) for name, verdict in verdicts.items()}


def _bits(rng: random.Random) -> list[str]:
    """Statements and branches of the files in MAP: most of them covered, each test others."""
    sizes = (sum(len(file[kind]) for file in MAP.values()) for kind in ("statements", "branches"))
    return [hex(sum((rng.random() < 0.8) << place for place in range(size))) for size in sizes]
