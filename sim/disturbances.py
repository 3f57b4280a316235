"""What can go wrong at the table, beside what the person's commands bring about; each is applied at a moment of a run.

Each is physical (legs, bodies, forces) or at a port of the world (speech, sensors), never a change of the code under
test. It is a function of the moment and of its parameters only, and takes no time: what comes later is done by nodes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from controller.ports import HumanReady, Request
from sim.events import FingersHeld, SupplyDisturbed, WayBlocked
from sim.geometry import Vector
from sim.gripper import FingerMotion
from sim.layout import HANDOVER_M, PICKUP_M, REST_HAND_M
from sim.leg import Leg
from sim.whereabouts import HANDOVER, hand_place
from sim.workshop import Workshop

Parameters = Mapping[str, float]

PLACES: Mapping[str, Vector] = {
    "pickup": (PICKUP_M[0], PICKUP_M[1], PICKUP_M[2] + 0.10),
    "handover": (HANDOVER_M[0], HANDOVER_M[1], HANDOVER_M[2] + 0.10),
    "resupply": (0.19, 0.47, 0.80),
    "home": (0.0, 0.20, 0.50),
}
"""Where somebody can lean into the arm's way (m): where the hand goes."""

FINGERS_M: Vector = (0.28, -0.38, 0.63)
"""The person's hand beside the leg at the pickup place, where the fingers close: they catch no leg."""


TUG_S = 1.0
"""How long a person tugs at a leg: more than twice the time in which a pull rises."""

APPROACH_M = 0.001
"""A hand that comes nearer by this much in a control tick approaches: 2 cm/s."""

ROOM_AGAIN_S = 0.5
"""Somebody who finds no room beside the arm tries again after this time."""


def leg_late(shop: Workshop, parameters: Parameters) -> None:
    """No leg comes to the pickup place for `for_s`; the one that waits there is put away."""
    shop.tell(SupplyDisturbed())
    shop.world.unfreeze()
    shop.world.legs.withhold(parameters["for_s"])


def leg_displaced(shop: Workshop, parameters: Parameters) -> None:
    """The leg that waits, or the next one, stands beside the pickup place by `dx_m` and `dy_m`."""
    shop.tell(SupplyDisturbed())
    shop.world.unfreeze()
    shop.world.legs.displace(parameters["dx_m"], parameters["dy_m"])


def leg_slips(shop: Workshop, parameters: Parameters) -> None:
    """From `after_s` after the next grasp on, the hand holds the leg with `grasp_n` only; a leg weighs 4.9 N.

    A leg that is in the hand already is not the next one.
    """
    legs = shop.world.legs
    held = legs.in_hand

    def grasps() -> bool:
        return legs.in_hand is not None and legs.in_hand is not held

    def weaken() -> None:
        if legs.in_hand is not None:
            shop.world.unfreeze()
            legs.in_hand.weaken(parameters["grasp_n"])

    shop.when(grasps, lambda: shop.later(parameters["after_s"], weaken))


def leg_taken(shop: Workshop, parameters: Parameters) -> None:
    """After `after_s` the person takes the leg that waits, and puts it down; the next one comes `next_s` later."""
    world = shop.world

    def reach() -> None:
        if world.legs.waiting is not None:
            duration_s = world.person.hand.move(world.legs.place())
            shop.later(duration_s, take)

    def take() -> None:
        leg = world.legs.waiting
        duration_s = world.person.hand.move(REST_HAND_M)
        if leg is not None:
            shop.tell(SupplyDisturbed())
            world.unfreeze()
            world.legs.take(world.person.hand.body, parameters["next_s"])
            shop.later(duration_s, lambda: set_down(leg))

    def set_down(leg: Leg) -> None:
        world.unfreeze()
        world.legs.set_down(leg)

    shop.later(parameters["after_s"], reach)


def leg_pulled_out(shop: Workshop, parameters: Parameters) -> None:
    """`after_s` after a leg is held out, the person tugs at it with `pull_n`: more than a grasp holds, or less.

    One that is not held out any more is out of their reach: tugged at over the bin, it fell beside it.
    """
    world = shop.world

    def tug(force_n: float) -> None:
        world.unfreeze()
        world.person.tug(force_n)

    def pull() -> None:
        if held_out():
            tug(parameters["pull_n"])
            shop.later(TUG_S, lambda: tug(0.0))

    def held_out() -> bool:
        return world.legs.in_hand is not None and hand_place(world.grasp_point()) == HANDOVER

    shop.when(held_out, lambda: shop.later(parameters["after_s"], pull))


def leg_in_hand(shop: Workshop, parameters: Parameters) -> None:
    """At the start of a run the leg is in the closed hand; later this is without effect."""
    if shop.world.time.step == 0:
        shop.world.gripper.begin_with_leg()


def somebody_in_the_way(shop: Workshop, parameters: Parameters) -> None:
    """After `after_s` somebody leans in at place number `place` of `PLACES`, when there is room, for `for_s`."""
    shop.later(parameters["after_s"], lambda: _lean_in(shop, _place(parameters), parameters["for_s"]))


def somebody_steps_in(shop: Workshop, parameters: Parameters) -> None:
    """When the hand next comes nearer than `near_m` to place number `place`, somebody leans in there, for `for_s`."""
    place, last_m = _place(parameters), 0.0

    def approaches() -> bool:
        nonlocal last_m
        before_m, last_m = last_m, math.dist(shop.world.grasp_point(), place)
        return last_m < parameters["near_m"] and last_m < before_m - APPROACH_M

    shop.when(approaches, lambda: _lean_in(shop, place, parameters["for_s"]))


def _place(parameters: Parameters) -> Vector:
    return list(PLACES.values())[int(parameters["place"])]


def _lean_in(shop: Workshop, place: Vector, for_s: float) -> None:
    def lean_out() -> None:
        shop.world.bystander.lean_out()
        shop.tell(WayBlocked(False))

    if shop.world.bystander.lean_in(place):
        shop.tell(WayBlocked(True))
        shop.later(for_s, lean_out)
    else:
        shop.later(ROOM_AGAIN_S, lambda: _lean_in(shop, place, for_s))


def hand_held_shut(shop: Workshop, parameters: Parameters) -> None:
    """When the hand opens next, the person holds its fingers shut for `grip_s`."""
    world = shop.world

    def opens() -> bool:
        return world.gripper.motion is FingerMotion.OPENING and world.legs.in_hand is not None

    def hold() -> None:
        shop.tell(FingersHeld())
        world.person.hold_shut(parameters["grip_s"])

    shop.when(opens, hold)


def hand_held_open(shop: Workshop, parameters: Parameters) -> None:
    """After `after_s` the person's hand is between the closing fingers at the pickup place, for `for_s`."""
    hand = shop.world.person.hand

    def withdraw() -> None:
        hand.move(REST_HAND_M)

    def reach() -> None:
        hand.move(FINGERS_M)
        shop.later(parameters["for_s"], withdraw)

    shop.later(parameters["after_s"], reach)


def sensors_silent(shop: Workshop, parameters: Parameters) -> None:
    """The sensors give no reading for `for_s`."""
    shop.sensors.faults.silent_until_s = shop.kernel.now_s + parameters["for_s"]


def sensors_late(shop: Workshop, parameters: Parameters) -> None:
    """The next reading is heard `late_s` after its measurement."""
    shop.sensors.faults.late_s = parameters["late_s"]


def sensors_stuck(shop: Workshop, parameters: Parameters) -> None:
    """For `for_s` readings are as the last one before."""
    shop.sensors.faults.stuck_until_s = shop.kernel.now_s + parameters["for_s"]


def gaze_flips(shop: Workshop, parameters: Parameters) -> None:
    """The gaze sensor reads the opposite until the turn is over."""
    shop.sensors.flip("gaze")


def pressure_flips(shop: Workshop, parameters: Parameters) -> None:
    """The pressure sensor reads the opposite until the turn is over."""
    shop.sensors.flip("pressure")


def location_flips(shop: Workshop, parameters: Parameters) -> None:
    """The location sensor reads the opposite until the turn is over."""
    shop.sensors.flip("location")


def says_ready(shop: Workshop, parameters: Parameters) -> None:
    """After `after_s` the person says "ready", whether it is time for it or not."""
    shop.later(parameters["after_s"], lambda: shop.human.say(HumanReady()))


def asks_again(shop: Workshop, parameters: Parameters) -> None:
    """After `after_s` the person asks for a leg, whether it is time for it or not."""
    shop.later(parameters["after_s"], lambda: shop.human.say(Request()))


def falls_silent(shop: Workshop, parameters: Parameters) -> None:
    """The person does not say the next "ready"."""
    shop.human.fall_silent()
