"""Sections that only some reports have, with an example of everything that can be in them."""

from typing import Any

MUTATION: dict[str, Any] = {
    "generated": 5,
    "seed": 0,
    "tests_per_mutant": 1,
    "matrix": False,
    "excluded_tests": ["rl-leg1-left-out"],
    "processes": 2,
    "wall_s": 61.5,
    "end_reason": "seconds",
    "total": {
        "mutants": 5,
        "killed": 1,
        "survived": 1,
        "unchanged": 1,
        "no_coverage": 1,
        "not_run": 1,
        "percent": 25.0,
    },
    "suites": {
        "rl": {
            "mutants": 5,
            "killed": 1,
            "survived": 1,
            "unchanged": 1,
            "no_coverage": 1,
            "not_run": 1,
            "percent": 25.0,
        }
    },
    "operators": {},
    "assertions": {"R1": {"killed": 1, "killed_only_by": 0}, "exception": {"killed": 1, "killed_only_by": 0}},
    "groups": {},
    "mutants": [
        {
            "id": f"0000000{place}",
            "file": "controller/states.py",
            "line": 12 + place,
            "operator": "message dropped",
            "before": "robot.bus.publish(State(name))\n<b>second</b>",
            "after": "pass",
            "executing": {} if status == "no coverage" else {"rl": 3},
            "runs": [{"test": "rl-x", "suite": "rl", "assertions": oracles, "changed": changed, "note": note}],
            "complete": status != "not run",
            "status": status,
            "difference": "rl-x: at 3.2 s `state(Reset)` is missing" if status == "survived" else "",
        }
        for place, (status, oracles, changed, note) in enumerate(
            [
                ("killed", ["R1", "exception"], True, "KeyError: <script>"),
                ("survived", [], True, ""),
                ("unchanged", [], False, ""),
                ("no coverage", [], False, ""),
                ("not run", [], False, ""),
            ]
        )
    ],
}
"""Mutants of each status."""

CLOSING = {
    "suite": "closure",
    "end_reason": "runs",
    "budget": 400,
    "runs": 400,
    "initial_runs": 2,
    "errored_runs": 1,
    "sim_s": 30211.5,
    "bound": 0.0075,
    "kinds": {
        "statement": {"hit": 2, "impossible": 1, "open": 1},
        "branch": {"hit": 0, "impossible": 0, "open": 1},
        "bin": {"hit": 1, "impossible": 4, "open": 12},
        "verdict": {"hit": 0, "impossible": 0, "open": 1},
    },
    "strategies": {
        "model": {"runs": 100, "sim_s": 7000.0, "new": {"statement": 1, "bin": 1}},
        "disturbances": {"runs": 300, "sim_s": 23211.5, "new": {"statement": 1}},
    },
    "growth": [
        {"run": 0, "sim_s": 0, "strategy": "initial_runs", "new": {"bin": 1}},
        {"run": 1, "sim_s": 70.25, "strategy": "model", "new": {"statement": 1}},
        {"run": 200, "sim_s": 14000.5, "strategy": "disturbances", "new": {"statement": 1}},
    ],
    "hit": [{"point": ["statement", "controller/states.py", "1"], "test": "closure-x", "strategy": "model", "run": 1}],
    "impossible": [
        {"point": ["statement", "controller/journal.py", "60"], "reason": "a <b>guard</b>", "by": "waived"},
        *({"point": ["bin", "handover", "000", leg], "reason": "the model", "by": "model"} for leg in "1234"),
    ],
    "open": [
        {
            "point": ["statement", "controller/states.py", "13"],
            "tries": 0,
            "test": "closure-near",
            "lacking": "line 12 (`if <script>:`) has to continue to it",
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
    "closest_tests": {"closure-near": "# id: closure-near\n# seed: 1\ntell leg\n"},
}
"""A loop that left points of several kinds open."""

PLAN = [
    {"name": "", "title": "Safe handover", "state": "failed", "goals": 2, "met": 1},
    {"name": "speed", "title": "Speed", "owner": "ana", "is_goal": True, "requirements": ["R4"], "state": "met"},
    {
        "name": "crush",
        "title": "No crush",
        "owner": "ben",
        "is_goal": True,
        "requirements": ["R3"],
        "state": "failed",
        "missing": ["R3 failed in 2 of 3 tests"],
    },
]
"""A plan with a goal that is met, and one that is not."""

CAUSES = [
    {
        "id": "3f2a91bc",
        "requirements": ["R2", "R3"],
        "tests": ["rl-one", "rl-two"],
        "state": "Offer",
        "minimal": ["tell leg"],
        "locations": [
            {
                "file": "controller/states.py",
                "line": 42,
                "function": "offer",
                "score": 0.87,
                "likely": True,
                "text": "state(42)",
            }
        ],
        "deciding_change": "<b>without</b> the disturbance it passes",
    },
    {"id": "9c", "requirements": ["R3"], "tests": ["rl-one"], "is_known": True},
]
"""A cause that is new, and a known one; the tests have these ids."""

SUGGESTIONS = {
    "suggestions": [
        {
            "id": "S1",
            "title": "After order, served follows within 9 s",
            "formula": "always(on(order) -> eventually[0:9](on(served)))",
            "form": "response",
            "triggers": 12,
            "decisive": 5,
            "margin": 1.5,
            "observed": "observed 7.5 s",
            "faults": 4,
            "new": 2,
            "added": 2,
        }
    ],
    "more": 1,
    "runs": 6,
    "validation_runs": 4,
    "candidates": 9,
    "refuted": 2,
    "faults": 8,
    "noticed": 3,
    "unreached": 1,
    "ignores_existing": False,
    "seed": 0,
    "wall_s": 12.5,
    "end_reason": "done",
    "notes": ["2 of 10 seeded bugs not tried: time ran out"],
}
