"""Taught arm poses (rad, in the order of ARM_JOINTS): the ways between home, pickup, handover and re-supply.

Taught on the simulated BERT2 (tests/sim/test_waypoints.py holds them to its kinematics): a leg that stands upright at
the pickup place is grasped 0.09 m above its middle, hangs upright at the handover place, and stays upright on the way
up from there within 2 degrees. Each way is a tuple of poses to be passed in order; a way may begin at the end
of any other.
"""

from __future__ import annotations

from controller.ports import JointPose

HOME: JointPose = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

_ABOVE_PICKUP: JointPose = (-0.917, -0.188, -0.63, -0.108, 1.282, 0.073, -0.034, -0.165, -0.046)
_AT_PICKUP: JointPose = (-1.126, 0.202, -0.644, -0.046, 1.386, -0.038, 0.056, -0.514, 0.07)

TO_PICKUP: tuple[JointPose, ...] = (
    (-0.5, 0.0, -0.75, 0.0, 1.39, 0.0, 0.0, -0.5, 0.0),
    _ABOVE_PICKUP,
    _AT_PICKUP,
)
"""Towards the leg, over it, down to it with the leg between palm and fingers."""

TO_HANDOVER: tuple[JointPose, ...] = (
    _ABOVE_PICKUP,
    (0.059, -0.081, -0.775, 0.011, 1.378, 0.035, -0.005, -0.135, -0.08),
)
"""Lift the leg, hold it out."""

TO_RESUPPLY: tuple[JointPose, ...] = ((0.9, -0.081, -0.775, 0.011, 1.378, 0.035, -0.005, -0.135, -0.08),)
"""Turn away from the person: the hand over the re-supply bin."""
