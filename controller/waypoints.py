"""Taught arm poses (rad, in the order of ARM_JOINTS): the ways between home, pickup, handover and re-supply."""

from __future__ import annotations

from controller.ports import JointPose

HOME: JointPose = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

TO_PICKUP: tuple[JointPose, ...] = (
    (-0.5, 0.0, -0.75, 0.0, 1.39, 0.0, 0.0, -0.5, 0.0),
    (-1.15, 0.05, -0.75, 0.0, 1.39, 0.0, 0.0, -0.5, 0.0),
    (-1.15, 0.05, -0.48, 0.0, 1.39, 0.0, 0.0, -0.5, 0.0),
)

TO_HANDOVER: tuple[JointPose, ...] = (
    (-1.15, 0.05, -0.75, 0.0, 1.39, 0.0, 0.0, -0.5, 0.0),
    (0.0, 0.05, -0.75, 0.0, 1.39, 0.0, 0.0, -0.5, 0.0),
)

TO_RESUPPLY: tuple[JointPose, ...] = ((0.9, 0.05, -0.75, 0.0, 1.39, 0.0, 0.0, -0.5, 0.0),)
