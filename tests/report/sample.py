"""A made-up report of any size, with the figures of a plausible run: as JSON data to change, and typed."""

import random
from typing import Any

import msgspec

from pytest_hricdv.results.model import Report, TestResult

PLANS = {"human": 48, "robot_code": 12}
PLANS_MISSED = ("plan47", "plan48")
TITLES = {
    "R1": "If gaze, pressure and location sense the human ready, then a leg shall be released",
    "R2": "If gaze, pressure or location sense the human not ready, then a leg shall not be released",
    "R3": "The robot shall not close its hand when the human hand is too close",
    "R4": "The robot shall start and work in restricted joint speed",
}
TEXTS = {
    "R1": "always(rise(gpl_ready) -> eventually[0:10](leg_released))",
    "R2": "always(rise(not_ready) -> not leg_released until request)",
    "R3": "always(hand_closing -> hand_distance >= 0.05 [hysteresis 0.005])",
    "R4": "always(moving -> joint_speed < 0.25)",
}

MUTATION = {
    "made": 5,
    "seed": 0,
    "tests_per_mutant": 1,
    "matrix": False,
    "left_out": ["rl-leg1-left-out"],
    "processes": 2,
    "wall_s": 61.5,
    "ended": "seconds",
    "total": {
        "mutants": 5,
        "killed": 1,
        "survived": 1,
        "unchanged": 1,
        "not_executed": 1,
        "not_tried": 1,
        "percent": 25.0,
    },
    "suites": {
        "rl": {
            "mutants": 5,
            "killed": 1,
            "survived": 1,
            "unchanged": 1,
            "not_executed": 1,
            "not_tried": 1,
            "percent": 25.0,
        }
    },
    "operators": {},
    "oracles": {"R1": {"killed": 1, "only": 0}, "exception": {"killed": 1, "only": 0}},
    "groups": {},
    "mutants": [
        {
            "id": f"0000000{place}",
            "file": "controller/states.py",
            "line": 12 + place,
            "operator": "message dropped",
            "before": "robot.bus.publish(State(name))\n<b>second</b>",
            "after": "pass",
            "executing": {} if status == "not executed" else {"rl": 3},
            "runs": [{"test": "rl-x", "suite": "rl", "oracles": oracles, "changed": changed, "note": note}],
            "complete": status != "not tried",
            "status": status,
            "difference": "rl-x: at 3.2 s `state(Reset)` is missing" if status == "survived" else "",
        }
        for place, (status, oracles, changed, note) in enumerate(
            [
                ("killed", ["R1", "exception"], True, "KeyError: <script>"),
                ("survived", [], True, ""),
                ("unchanged", [], False, ""),
                ("not executed", [], False, ""),
                ("not tried", [], False, ""),
            ]
        )
    ],
}
"""Mutants of each status."""

CLOSING = {
    "suite": "closure",
    "ended": "runs",
    "budget": 400,
    "runs": 400,
    "given": 2,
    "erring": 1,
    "sim_s": 30211.5,
    "bound": 0.0075,
    "kinds": {
        "statement": {"hit": 2, "impossible": 1, "open": 1},
        "branch": {"hit": 0, "impossible": 0, "open": 1},
        "bin": {"hit": 1, "impossible": 4, "open": 12},
        "verdict": {"hit": 0, "impossible": 0, "open": 1},
    },
    "ways": {
        "model": {"runs": 100, "sim_s": 7000.0, "new": {"statement": 1, "bin": 1}},
        "disturbances": {"runs": 300, "sim_s": 23211.5, "new": {"statement": 1}},
    },
    "growth": [
        {"run": 0, "sim_s": 0, "way": "given", "new": {"bin": 1}},
        {"run": 1, "sim_s": 70.25, "way": "model", "new": {"statement": 1}},
        {"run": 200, "sim_s": 14000.5, "way": "disturbances", "new": {"statement": 1}},
    ],
    "good_turing": {"once": 2, "hits": 90000, "share": 2 / 90000, "points": 0.005},
    "hit": [{"point": ["statement", "controller/states.py", "1"], "test": "closure-x", "way": "model"}],
    "impossible": [
        {"point": ["statement", "controller/journal.py", "60"], "reason": "a <b>guard</b>", "by": "waived"},
        *({"point": ["bin", "handover", "000", leg], "reason": "the model", "by": "model"} for leg in "1234"),
    ],
    "open": [
        {
            "point": ["statement", "controller/states.py", "13"],
            "tries": 0,
            "test": "closure-near",
            "lacking": "line 12 (`if <script>:`) has to go on to it",
            "waiver": "controller/states.py:13: # unreachable: why",
        },
        {"point": ["branch", "controller/states.py", "12", "-10"], "tries": 1, "bound": 1.0},
        {
            "point": ["verdict", "R1", "Passed"],
            "tries": 120,
            "bound": 0.025,
            "lacking": "reading.gaze & reading.pressure",
        },
        *(
            {
                "point": ["bin", "handover", f"{n:03b}", leg],
                "tries": 100 + n,
                "bound": 3 / (100 + n),
                "test": "closure-near",
                "lacking": "leg 4 instead of 3",
                "waiver": f"cross product handover: impossible={{('{n:03b}', '{leg}'): \"why\"}}",
            }
            for n in (1, 2, 3, 4)
            for leg in "123"
        ),
    ],
    "violations": [
        {
            "requirement": "R4",
            "part": "joint_speed < 0.25",
            "state": "Reset",
            "outcome": "released",
            "runs": 1,
            "test": "closure-x",
        },
        {"requirement": "", "part": "the robot raised <b>KeyError</b>", "runs": 2, "test": "closure-x"},
        {"requirement": "R3", "part": "hand_distance >= 0.05", "known": True, "runs": 7, "test": "closure-y"},
    ],
    "nearest": {"closure-near": "# id: closure-near\n# seed: 1\ntell leg\n"},
}
"""A loop that left points of several kinds open."""

GPL = tuple(f"{n:03b}" for n in range(8))
LEGS = ("1", "2", "3", "4")
MAP = {
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


def report(suites: tuple[str, ...] = ("rl",), tests: int = 3, seed: int = 0) -> Report:
    """A report with `tests` tests in each suite."""
    return typed(data(suites, tests, seed))


def typed(data: dict[str, Any]) -> Report:
    """A report of JSON data; raises msgspec.ValidationError where the data breaks the contract."""
    return msgspec.convert(data, Report)


def result(rng: random.Random, suite: str = "rl") -> TestResult:
    """A single test."""
    return msgspec.convert(test(rng, suite), TestResult)


def data(suites: tuple[str, ...] = ("rl",), tests: int = 3, seed: int = 0) -> dict[str, Any]:
    """The JSON data of a report with `tests` tests in each suite."""
    rng = random.Random(seed)
    made = [test(rng, name) for name in suites for _ in range(tests)]
    return {
        "schema": "hricdv-report/1",
        "version": "0.1.0",
        "testbench": "table-assembly",
        "selected": len(made),
        "reported": len(made),
        "not_run": 0,
        "not_run_tests": [],
        "wall_s": 0.53 * len(made),
        "workers": 2,
        "known_violations": {"R3": "no crush prevention"},
        "known_until": {},
        "strict": False,
        "rerun": {"suite": "", "options": []},
        "outcome_label": "legs",
        "exploration": {},
        "closure": closure(made) | {"gaps": gaps(made)},
        "requirements": {
            name: {"title": title, "source": "ISO 13482:2014", "text": TEXTS[name]} for name, title in TITLES.items()
        },
        "units": {"arm_speed": "rad/s"},
        "state": "state.name",
        "code_under_test": code_under_test(),
        "models": models(),
        "cross_products": {"handover": handover()},
        "suites": [suite(rng, name, [each for each in made if each["suite"] == name]) for name in suites],
        "tests": made,
    }


def code_under_test() -> dict[str, Any]:
    """Two files, one of them complete."""
    return {
        "packages": ["controller"],
        "sha256": "9f" * 32,
        "measured": True,
        "reason": "",
        "map": [{"file": name, **listed} for name, listed in MAP.items()],
        "waivers": [{"file": "controller/journal.py", "line": 60, "reason": "the port never closes in simulation"}],
        "files": [
            {
                "file": "controller/journal.py",
                "statements": 45,
                "covered": 42,
                "missing_lines": [60, 61, 70],
                "missing_branches": [[58, 60], [69, -12]],
            },
            {
                "file": "controller/states.py",
                "statements": 278,
                "covered": 278,
                "missing_lines": [],
                "missing_branches": [],
            },
        ],
    }


def models() -> dict[str, Any]:
    """Sources of as many plans as PLANS has, each on a line of its own."""
    return {
        agent: {
            "file": f"models_bdi/{agent}.asl",
            "source": "".join(f"@plan{n} +!goal{n} <- act{n}.\n" for n in range(1, total + 1)),
            "plans": {f"plan{n}": n for n in range(1, total + 1)},
        }
        for agent, total in PLANS.items()
    }


def handover() -> dict[str, Any]:
    """A cross product of 8 leg poses and 4 legs."""
    return {
        "coordinates": [{"name": "gpl", "bins": list(GPL)}, {"name": "leg", "bins": list(LEGS)}],
        "impossible": [{"bin": ["000", leg], "reason": "the model never does", "by": "model"} for leg in LEGS],
        "illegal": [],
        "proof": {"status": "proven", "reason": "", "runs": 812},
    }


def crossed() -> dict[str, Any]:
    """What a suite hit of it."""
    bins = [(gpl, leg) for gpl in GPL for leg in LEGS]
    hits, missing = bins[4:-8], bins[-8:]
    figures = {"bins": 32, "hit": 20, "impossible": 4, "illegal": 0}
    bins_hit = {
        "hits": [{"bin": list(each), "tests": 1 + n % 5, "hits": 1 + n % 7} for n, each in enumerate(hits)],
        "missing": [list(each) for each in missing],
    }
    return {**figures, "missing": [" x ".join(each) for each in missing], "products": {"handover": figures | bins_hit}}


def suite(rng: random.Random, name: str, tests: list[dict[str, Any]]) -> dict[str, Any]:
    """A suite whose verdicts are counted from its tests and whose coverage is made up."""
    learned = name == "rl"
    return {
        "name": name,
        "seed": 0,
        "generation": {
            "wall_s": 3.1,
            "bdi_runs": 812,
            "iterations": 130 if learned else 0,
            "converged_at": 130 if learned else None,
            "q_delta": [10.0 * 0.93**n * rng.uniform(0.5, 1) for n in range(130)] if learned else [],
            "distinct_texts": min(len(tests), 97),
            "cached": False,
            "reward": "plans" if learned else "",
            "notes": [],
            "diagnosis": {
                "distinct_subsets": min(len(tests), 60),
                "belief_entropy_bits": 2.5,
                "belief_entropy_most_bits": 3.0,
                "plans_executed": {"human": 46, "robot_code": 12},
                "last_new_plan": {"iteration": 94 if learned else None, "test": min(len(tests), 23)},
            },
        },
        "size": len(tests),
        "tests": len(tests),
        "fidelity": "",
        "requirements": {requirement: _counted(tests, requirement) for requirement in TITLES},
        "code": {
            "statements": _covered(260 + rng.randrange(40), 323, 320),
            "branches": _covered(60 + rng.randrange(20), 92, 90),
        },
        "plans": {
            agent: {
                "covered": [f"plan{n}" for n in range(1, total - 1)],
                "missing": [f"plan{total - 1}", f"plan{total}"],
                "total": total,
                "declared": [f"plan{n}" for n in range(1, total + 1)],
                "reached": {
                    f"plan{n}": {"tests": n, "belief_sets": n, "shortest": ["leg4"], "test": tests[0]["id"]}
                    for n in range(1, total - 1)
                }
                if tests
                else {},
            }
            for agent, total in PLANS.items()
        },
        "cross": crossed(),
        "curve": _curve(rng, len(tests)),
        "closure": closure(tests),
    }


def closure(tests: list[dict[str, Any]]) -> dict[str, Any]:
    """The first half of the tests are enough, and the others add nothing."""
    half = tests[: len(tests) // 2]
    return {
        "points": 10 * len(half),
        "sim_s": 9000.0,
        "growth": [[100.0 * n, 10 * n] for n in range(1, len(half))],
        "minimal": [
            {"nodeid": test["nodeid"], "id": test["id"], "gain": 9 - n % 9, "points": 10 * n, "sim_s": 100.0 * n}
            for n, test in enumerate(half, start=1)
        ],
        "adds_nothing": [test["nodeid"] for test in tests[len(half) :]],
        "unique": {half[0]["nodeid"]: 3} if half else {},
    }


def gaps(tests: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Two plans of the same reason, and a waived line."""
    reason = {"kind": "plans", "place": "human", "reason": "no test has beliefs that trigger it"}
    nearest = {"suggestion": "the beliefs leg1 m000l1 reach it", "beliefs": ["leg1", "m000l1"]}
    waived = {"kind": "statements", "place": "controller/journal.py", "reason": "waived as unreachable: so"}
    return [
        *({**reason, **nearest, "items": [plan], "test": tests[0]["id"] if tests else ""} for plan in PLANS_MISSED),
        {**waived, "items": ["60"], "suggestion": "", "test": "", "beliefs": []},
    ]


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
    failed = {name for name, found in verdicts.items() if found["verdict"] == "Failed"}
    return {
        "nodeid": f"tests/hri/test_table_assembly.py::test_table_assembly[{action_id}]",
        "suite": suite,
        "id": action_id,
        "aim": "plans",
        "name": "",
        "beliefs": [f"leg{5 - len(legs)}", *(f"m{rng.randrange(8):03b}l{n}" for n in range(1, len(legs) + 1))],
        "abstract": abstract,
        "concrete": {
            "actions": [{"command": each, "parameters": {"voice_s": rng.uniform(2, 5)}} for each in abstract],
            "run": {"sensing_timeout_s": rng.uniform(10, 100)},
        },
        "seed": rng.randrange(2**31),
        "outcome": "failed" if failed - {"R3"} else "known-violation" if failed else "passed",
        "wall_s": rng.uniform(0.3, 0.9),
        "sim_s": rng.uniform(40, 300),
        "frozen_s": rng.uniform(10, 40),
        "fidelity": "",
        "ended": "table done",
        "unmeasured": "",
        "legs": legs,
        "record_sha256": f"{rng.getrandbits(256):064x}",
        "requirements": verdicts,
        "plans": {agent: [f"plan{n}" for n in range(1, total, 2)] for agent, total in PLANS.items()},
        "code": {"statements": 250, "percent": min(rng.gauss(78, 6), 100.0), "bits": _bits(rng)},
        "cross": {"handover": [[rng.choice(GPL[1:]), rng.choice(LEGS)] for _ in legs]},
        "failure": "",
        "timeline": timeline(rng, verdicts),
    }


def timeline(rng: random.Random, verdicts: dict[str, Any]) -> dict[str, Any]:
    """A run of 60 s: states, two messages, a switch, a signal, and an attempt for each trigger."""
    speeds = " ".join(f"{n} {rng.uniform(0, 0.24):.3g}" for n in range(0, 60, 2))
    states = [f'{n}\trobot\tstate\t{{"name":"{name}"}}' for n, name in enumerate(("Wait", "Fetch", "Offer", "Done"))]
    marks = {"Passed": ["1-2", "41.25-51.5"], "Failed": ["1-2", "41.25-51.5!"], "NC": []}
    attempts = {name: " ".join(marks[found["verdict"]]) for name, found in verdicts.items() if found["triggers"]}
    return {
        "end_s": 60.0,
        "messages": [*states, "5.5\thuman\trequest\t{}", '51.5\tsensors\treading\t{"gaze":true}'],
        "signals": {"arm_speed": speeds, "leg_held": "0 0 7.5 1 50 0"},
        "attempts": attempts,
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
        "vacuous": int(outcome == "NC"),
        "pending": 0,
        "margin": None if outcome == "NC" else -0.02 if failed else margin,
        "margin_time_s": None if outcome == "NC" else 51.5,
        "nearest_miss": miss if outcome == "NC" else None,
        "violations": [violation] if failed else [],
    }


def _counted(tests: list[dict[str, Any]], requirement: str) -> dict[str, int]:
    found = [each["requirements"][requirement] for each in tests]
    verdicts = [each["verdict"] for each in found]
    return {
        "passed": verdicts.count("Passed"),
        "failed": verdicts.count("Failed"),
        "nc": verdicts.count("NC"),
        **{
            name: sum(each[name] for each in found) for name in ("triggers", "passes", "failures", "vacuous", "pending")
        },
    }


def _covered(covered: int, total: int, reachable: int) -> dict[str, Any]:
    return {
        "covered": covered,
        "total": total,
        "reachable": reachable,
        "percent": 100 * covered / total,
        "percent_reachable": 100 * covered / reachable,
    }


def _curve(rng: random.Random, tests: int) -> list[dict[str, int]]:
    statements, branches, plans, steps = 190, 35, 18, []
    for number in range(1, tests + 1):
        statements += (280 - statements) // rng.randint(3, 12)
        branches += (75 - branches) // rng.randint(3, 12)
        plans += (56 - plans) // rng.randint(3, 12)
        steps.append({"tests": number, "statements": statements, "branches": branches, "plans": plans})
    return steps


def _bits(rng: random.Random) -> list[str]:
    """Statements and branches of the files in MAP: most of them covered, each test others."""
    sizes = (sum(len(file[kind]) for file in MAP.values()) for kind in ("statements", "branches"))
    return [hex(sum((rng.random() < 0.8) << place for place in range(size))) for size in sizes]
