"""A made-up report of any size, with the figures of a plausible run: as JSON data to change, and typed."""

import random
from typing import Any

import msgspec

from pytest_hricdv.results.model import Report
from tests.report.sample_tests import GPL, LEGS, MAP, PLANS, TITLES, test

PLANS_MISSED = ("plan47", "plan48")
TEXTS = {
    "R1": "always(rise(gpl_ready) -> eventually[0:10](leg_released))",
    "R2": "always(rise(not_ready) -> not leg_released until request)",
    "R3": "always(hand_closing -> hand_distance >= 0.05 [hysteresis 0.005])",
    "R4": "always(moving -> joint_speed < 0.25)",
}


def unmeasured(reason: str, tests: int = 2) -> dict[str, Any]:
    """The data of a report of code that was not measured."""
    made = data(tests=tests)
    made["code_under_test"] |= {"measured": False, "reason": reason, "files": []}
    made["suites"][0]["code"] = {"statements": None, "branches": None}
    for result in made["tests"]:
        result["code"] = None
    return made


def report(suites: tuple[str, ...] = ("rl",), tests: int = 3, seed: int = 0) -> Report:
    """A report with `tests` tests in each suite."""
    return typed(data(suites, tests, seed))


def typed(data: dict[str, Any]) -> Report:
    """A report of JSON data; raises msgspec.ValidationError where the data breaks the contract."""
    return msgspec.convert(data, Report)


def data(suites: tuple[str, ...] = ("rl",), tests: int = 3, seed: int = 0) -> dict[str, Any]:
    """The JSON data of a report with `tests` tests in each suite."""
    rng = random.Random(seed)
    made = [test(rng, name) for name in suites for _ in range(tests)]
    return {
        "schema": "hricdv-report/3",
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
        "rerun_options": {"suite": "", "options": []},
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
        "suites": [suite(rng, name, [test for test in made if test["suite"] == name]) for name in suites],
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
        "hits": [{"bin": list(bin_), "tests": 1 + n % 5, "hits": 1 + n % 7} for n, bin_ in enumerate(hits)],
        "missing": [list(bin_) for bin_ in missing],
    }
    return {**figures, "missing": [" x ".join(bin_) for bin_ in missing], "products": {"handover": figures | bins_hit}}


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
    reason = {"kind": "plans", "location": "human", "reason": "no test has beliefs that trigger it"}
    nearest = {"suggestion": "the beliefs leg1 m000l1 reach it", "beliefs": ["leg1", "m000l1"]}
    waived = {"kind": "statements", "location": "controller/journal.py", "reason": "waived as unreachable: so"}
    return [
        *({**reason, **nearest, "items": [plan], "test": tests[0]["id"] if tests else ""} for plan in PLANS_MISSED),
        {**waived, "items": ["60"], "suggestion": "", "test": "", "beliefs": []},
    ]


def _counted(tests: list[dict[str, Any]], requirement: str) -> dict[str, int]:
    results = [test["requirements"][requirement] for test in tests]
    verdicts = [result["verdict"] for result in results]
    return {
        "passed": verdicts.count("Passed"),
        "failed": verdicts.count("Failed"),
        "nc": verdicts.count("NC"),
        **{
            name: sum(result[name] for result in results)
            for name in ("triggers", "passes", "failures", "untriggered", "pending")
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
