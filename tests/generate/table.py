"""The table assembly's data, as a testbench declares it."""

from __future__ import annotations

from itertools import product
from pathlib import Path

from pytest_hricdv.generate.beliefs import BeliefSpace
from pytest_hricdv.generate.concrete import Concretization
from pytest_hricdv.generate.context import GenerationContext
from pytest_hricdv.generate.model import Model
from pytest_hricdv.generate.sampler import Constant, Sometimes, Uniform

ROOT = Path(__file__).parents[2]
POSES = tuple("".join(bits) for bits in product("01", repeat=3))
SPACE = BeliefSpace(
    start=("leg1", "leg2", "leg3", "leg4"),
    groups={
        "boredom": ("bored", "not_bored"),
        **{f"leg {leg}": tuple(f"m{pose}l{leg}" for pose in POSES) for leg in range(1, 5)},
    },
    id_groups=("boredom",),
    default_beliefs=("not_bored",),
)
MODEL = Model(ROOT / "models_bdi" / "table_assembly.mas2j")
CONCRETIZATION = Concretization(
    commands={
        "tell leg": {"voice_s": Constant(3.0, "s"), "hand_x_m": Uniform(-0.1, 0.4, "m")},
        "receivesignal": {"patience_s": Constant(60.0, "s")},
        "set_param gaze = 1": {
            "offset_m": Uniform(0.1, 0.2, "m"),
            "angle_deg": Uniform(15.0, 40.0, "deg", open_high=True),
        },
        "set_param gaze = 0": {"offset_m": Uniform(0.2, 0.5, "m"), "angle_deg": Uniform(40.0, 50.0, "deg")},
        "set_param pressure = 1": {"pull_n": Uniform(5.0, 15.0, "N")},
        "set_param pressure = 0": {"pull_n": Sometimes(0.05, Uniform(1.0, 3.0, "N"))},
        "set_param location = 1": {"off_m": Uniform(0.0, 0.03, "m")},
        "set_param location = 0": {"off_m": Uniform(0.5, 0.75, "m")},
        "tell humanReady": {"voice_s": Uniform(2.0, 3.0, "s")},
        "bored": {},
    },
    run={"sensing_timeout_s": Uniform(10.0, 100.0, "s")},
)
COMMANDS = tuple(CONCRETIZATION.commands)
CONTEXT = GenerationContext(MODEL, SPACE, COMMANDS, by_hand=ROOT / "tests" / "hri" / "by_hand.toml")
