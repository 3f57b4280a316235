"""What can go wrong around the robot: each is a line `disturb NAME` of a test."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from house.house import House

from pytest_hricdv.runtime import Kernel
from pytest_hricdv.testbench import Delay, Disturbance, Drop, Duplicate, Uniform

Values = Mapping[str, float]


@dataclass(frozen=True)
class Flat:
    """What a disturbance acts on: the world, and its time."""

    kernel: Kernel
    house: House


def food_taken(flat: Flat, values: Values) -> None:
    """The person takes what is in the gripper, when it is there."""

    def take() -> None:
        if flat.house.wait(lambda: flat.house.gripper.holds, values["within_s"]):
            flat.kernel.sleep(values["after_s"])
            flat.house.take_food()

    flat.kernel.spawn("somebody takes the food", take)


def gripper_jams(flat: Flat, values: Values) -> None:
    """The gripper does not move for a while."""

    def jam() -> None:
        flat.house.gripper.jammed = True
        flat.kernel.sleep(values["for_s"])
        flat.house.gripper.jammed = False

    flat.kernel.spawn("the gripper jams", jam)


def battery_low(flat: Flat, values: Values) -> None:
    """The battery is emptier than one thought."""
    flat.house.battery_is(values["level"])


def dog_jumps(flat: Flat, values: Values) -> None:
    """The dog jumps aside, be it into the robot."""
    flat.house.dog_jumps(values["dx_m"], values["dy_m"])


JUMP = Uniform(-1.0, 1.0, "m")
"""As far as that of the published case, which steps of up to 1 m were drawn for."""

DISTURBANCES: Mapping[str, Disturbance | Drop | Delay | Duplicate] = {
    "order_lost": Drop("order"),
    "order_late": Delay("order", Uniform(1.0, 60.0, "s")),
    "order_doubled": Duplicate("order", Uniform(0.5, 60.0, "s")),
    "answer_lost": Drop("accepted"),
    "food_taken": Disturbance({"within_s": Uniform(100.0, 300.0, "s"), "after_s": Uniform(0.0, 20.0, "s")}, food_taken),
    "gripper_jams": Disturbance({"for_s": Uniform(20.0, 200.0, "s")}, gripper_jams),
    "battery_low": Disturbance({"level": Uniform(0.1, 0.2)}, battery_low),
    "dog_jumps": Disturbance({"dx_m": JUMP, "dy_m": JUMP}, dog_jumps),
}
