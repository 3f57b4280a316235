"""What the models of `models_bdi` are steered by: the beliefs that a test is chosen from."""

from __future__ import annotations

from pathlib import Path

from pytest_hricdv.testbench import BeliefSpace, Model

MODELS = Path(__file__).parents[1] / "models_bdi"

MODEL = Model(MODELS / "home_care.mas2j", actor="person", covered=("person", "robot"))

_ORDERS = ("fridge", "sink", "feed", "clean", "unknown")

BELIEFS = BeliefSpace(
    start=tuple(f"first_{order}" for order in _ORDERS),
    groups={
        "second": tuple(f"second_{order}" for order in _ORDERS),
        "third": tuple(f"third_{order}" for order in _ORDERS),
        "manner": (
            "patient",
            "impatient",
            "insistent",
            "fickle",
            "meddling",
            "obstinate",
            "restless",
            "lingering",
        ),
        "unknown": ("says_whatever", "says_chase", "says_opendoor", "says_recharge"),
        "dog": ("dog_lies", "dog_follows"),
        "end": ("stays", "leaves"),
    },
    id_groups=("manner",),
    default_beliefs=("patient", "says_whatever", "dog_lies", "stays"),
)
"""Three orders, of which any may come twice; a manner; what an unknown order is; the dog; and how it ends."""

LENGTHS = (1, 6)
"""Fewest and most actions of a pseudorandom test (chosen: those of the models have up to 13, the published ones 3)."""
