"""Taught poses of the arm (rad, nine joints): the ways between home, pickup, handover and re-supply."""

HOME = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

_ABOVE_PICKUP = (-0.917, -0.188, -0.63, -0.108, 1.282, 0.073, -0.034, -0.165, -0.046)
_AT_PICKUP = (-1.126, 0.202, -0.644, -0.046, 1.386, -0.038, 0.056, -0.514, 0.07)

TO_PICKUP = (
    (-0.5, 0.0, -0.75, 0.0, 1.39, 0.0, 0.0, -0.5, 0.0),
    _ABOVE_PICKUP,
    _AT_PICKUP,
)
"""Towards the leg, over it, down to it with the leg between palm and fingers."""

TO_HANDOVER = (
    _ABOVE_PICKUP,
    (0.059, -0.081, -0.775, 0.011, 1.378, 0.035, -0.005, -0.135, -0.08),
)
"""Lift the leg, hold it out."""

TO_RESUPPLY = ((0.9, -0.081, -0.775, 0.011, 1.378, 0.035, -0.005, -0.135, -0.08),)
"""Turn away from the person: the hand over the re-supply bin."""
