"""Patterns of requirements for robots that work with people, such as `speed_and_separation` and `protective_stop`.

They follow ISO 10218-1:2025 and ISO 10218-2:2025, which take in ISO/TS 15066:2016, and, for personal care robots,
ISO 13482:2014. Where a pattern names a clause, it is of the edition that stands before it. A requirement made from a
pattern says what a run is checked for; it is not evidence of conformity to a standard, which asks for a risk assessment
and for measurements. No limit is built in: distances, speeds, times, forces and pressures are arguments, and come from
the user's own assessment.

Speeds are magnitudes, in the unit of their signal (m/s, rad/s); `standstill` is the largest one that counts as standing
still, in the same unit. Limits may be computed from signals, for instance a distance from the present speed.
"""

from __future__ import annotations

from pytest_hricdv.monitor.build import always, historically, once, since
from pytest_hricdv.monitor.dsl import NumberValue, TruthValue
from pytest_hricdv.monitor.formula import Formula
from pytest_hricdv.monitor.patterns.pattern import PatternError, as_event, pattern, require_duration


@pattern
def speed_and_separation(
    speed: NumberValue,
    distance: NumberValue,
    *,
    stop_distance_m: NumberValue | float,
    slow_distance_m: NumberValue | float | None = None,
    slow_speed: NumberValue | float | None = None,
    standstill: float = 0.0,
) -> Formula:
    """Nearer to a person than `stop_distance_m`, the robot stands still; nearer than `slow_distance_m`, it is slow.

    Formula: `always(distance < stop_distance_m -> speed <= standstill)`, or with a slow zone
    `always(distance < slow_distance_m -> distance >= stop_distance_m & speed <= slow_speed | speed <= standstill)`.
    Scope: while a person is that near. A separation distance that grows with the speed is written as a term, such as
    `0.2 + 0.3 * arm_speed`. Source: speed and separation monitoring, ISO 10218-2:2025; ISO/TS 15066:2016, 5.5.4.

    Args:
        speed: the speed of the robot, not negative.
        distance: between robot and person (m).

    Raises:
        PatternError: one of `slow_distance_m` and `slow_speed` without the other, a slow zone that is not larger than
            the other, or an argument of a wrong type.

    >>> from pytest_hricdv.monitor.build import signal
    >>> speed, distance = signal("arm_speed"), signal("person_distance")
    >>> print(speed_and_separation(speed, distance, stop_distance_m=0.3, slow_distance_m=1.0, slow_speed=0.25))
    always(person_distance < 1 -> person_distance >= 0.3 & arm_speed <= 0.25 | arm_speed <= 0)
    """
    stands = speed <= standstill
    if slow_distance_m is None or slow_speed is None:
        if slow_distance_m is not None or slow_speed is not None:
            present = "slow_speed" if slow_distance_m is None else "slow_distance_m"
            raise PatternError(present, "expected both slow_distance_m and slow_speed, or neither")
        return always((distance < stop_distance_m) >> stands)
    near = distance < slow_distance_m
    slow = (distance >= stop_distance_m) & (speed <= slow_speed)
    if isinstance(slow_distance_m, NumberValue) or isinstance(stop_distance_m, NumberValue):
        # Only the run decides which zone is larger.
        return always((near | (distance < stop_distance_m)) >> (slow | stands))
    if slow_distance_m <= stop_distance_m:
        problem = f"expected more than stop_distance_m, which is {stop_distance_m}, got {slow_distance_m}"
        raise PatternError("slow_distance_m", problem)
    return always(near >> (slow | stands))


@pattern
def protective_separation(
    speed: NumberValue,
    distance: NumberValue,
    *,
    v_h: NumberValue | float,
    t_r: float,
    t_s: float,
    v_r: NumberValue | float,
    s_s: NumberValue | float,
    c: NumberValue | float = 0.0,
    z_d: NumberValue | float = 0.0,
    z_r: NumberValue | float = 0.0,
    standstill: float = 0.0,
) -> Formula:
    """While the robot moves, the person is at least the protective separation distance away.

    The distance is `S_p = S_h + S_r + S_s + C + Z_d + Z_r`, with `S_h = v_h * (T_r + T_s)`, how far the person comes
    until the robot stands still, and `S_r = v_r * T_r`, how far the robot moves until it brakes.

    Formula: `always(speed > standstill -> distance >= v_h * (t_r + t_s) + v_r * t_r + s_s + c + z_d + z_r)`.
    Scope: while the robot moves. Source: speed and separation monitoring, ISO 10218-2:2025; ISO/TS 15066:2016,
    5.5.4.2.3, with constant speeds.

    Args:
        speed: the speed of the robot, not negative.
        distance: between robot and person (m).
        v_h: speed of the person towards the robot (m/s).
        t_r: reaction time of the robot, sensors and control included (s).
        t_s: stopping time of the robot (s).
        v_r: speed of the robot towards the person (m/s).
        s_s: stopping distance of the robot (m).
        c: intrusion distance, how far a part of the body reaches into the field before it is sensed (m).
        z_d: uncertainty of the person's position (m).
        z_r: uncertainty of the robot's position (m).

    Raises:
        PatternError: an argument of a wrong type.

    >>> from pytest_hricdv.monitor.build import signal
    >>> speed, distance = signal("arm_speed"), signal("person_distance")
    >>> print(protective_separation(speed, distance, v_h=2.0, t_r=0.25, t_s=0.5, v_r=speed, s_s=0.125, z_d=0.125))
    always(arm_speed > 0 -> person_distance >= 1.5 + arm_speed * 0.25 + 0.25)
    """
    terms = (v_h * (t_r + t_s), v_r * t_r, s_s, c, z_d, z_r)
    constant = sum(term for term in terms[2:] if not isinstance(term, NumberValue))
    needed: NumberValue | float = terms[0]
    for term in (terms[1], *(term for term in terms[2:] if isinstance(term, NumberValue)), constant):
        needed = needed + term
    return always((speed > standstill) >> (distance >= needed))


@pattern
def power_and_force(
    force: NumberValue,
    *,
    limit_n: NumberValue | float,
    transient_limit_n: NumberValue | float | None = None,
    transient_s: float | None = None,
) -> Formula:
    """While the robot touches a person, the force does not exceed the limit.

    With a transient limit, the force may be between both limits for less than `transient_s` seconds.

    Formula: `always(force > 0 -> force <= limit_n)`, or `always(force > 0 -> force <= transient_limit_n &
    !(force > limit_n [for transient_s]))`. Scope: while there is contact. Source: power and force limiting,
    ISO 10218-2:2025; ISO/TS 15066:2016, 5.5.5. The limit depends on the part of the body; the requirement's `source`
    says where it comes from.

    Args:
        force: between robot and person (N), not negative.

    Raises:
        PatternError: one of `transient_limit_n` and `transient_s` without the other, or an argument of a wrong type.

    >>> from pytest_hricdv.monitor.build import signal
    >>> print(power_and_force(signal("contact_force"), limit_n=signal("force_limit")))
    always(contact_force > 0 -> contact_force <= force_limit)
    """
    return _limit(force, limit_n, transient_limit_n, transient_s, "transient_limit_n")


@pattern
def contact_pressure(
    pressure: NumberValue,
    *,
    limit_n_cm2: NumberValue | float,
    transient_limit_n_cm2: NumberValue | float | None = None,
    transient_s: float | None = None,
) -> Formula:
    """While the robot touches a person, the pressure does not exceed the limit (N/cm2).

    Formula, with a transient limit or without: as of `power_and_force`. Scope: while there is contact. Source: power
    and force limiting, ISO 10218-2:2025; ISO/TS 15066:2016, 5.5.5. The requirement's `source` says where the limit
    comes from.

    Args:
        pressure: the pressure of the contact (N/cm2), not negative.

    Raises:
        PatternError: as from `power_and_force`.

    >>> from pytest_hricdv.monitor.build import signal
    >>> limits = {"limit_n_cm2": signal("limit"), "transient_limit_n_cm2": 2 * signal("limit"), "transient_s": 0.5}
    >>> print(contact_pressure(signal("pressure"), **limits))
    always(pressure > 0 -> pressure <= 2 * limit & !(pressure > limit [for 0.5]))
    """
    return _limit(pressure, limit_n_cm2, transient_limit_n_cm2, transient_s, "transient_limit_n_cm2")


@pattern
def protective_stop(
    condition: TruthValue,
    speed: NumberValue,
    *,
    within_s: float,
    until: TruthValue | None = None,
    standstill: float = 0.0,
) -> Formula:
    """Once the condition has held for `within_s` seconds, the robot stands still as long as it holds.

    With `until`, the stop is in force from the condition on until that event, such as a restart; an event, such as
    `on(stop)`, needs it.

    Formula: `always(historically[0:within_s](condition) -> speed <= standstill)`, with `until` for the condition
    `!until since condition`. Scope: while the stop is in force, `within_s` excepted; a condition that ends sooner is
    not checked, and one that is true when the run begins counts as always true before. Source: protective stop,
    ISO 10218-1:2025 (5.5.3 in the edition of 2011); ISO 13482:2014.

    Raises:
        PatternError: an event without `until`, or an argument of a wrong type.

    >>> from pytest_hricdv.monitor.build import on, signal
    >>> print(protective_stop(signal("person_inside"), signal("arm_speed"), within_s=0.5))
    always(historically[0:0.5](person_inside) -> arm_speed <= 0)
    >>> print(protective_stop(on("stop"), signal("arm_speed"), within_s=0.5, until=on("restart")))
    always(historically[0:0.5](!on(restart) since on(stop)) -> arm_speed <= 0)
    """
    stopped = require_duration(condition, "condition") if until is None else since(~as_event(until), condition)
    return always(historically(stopped, 0, within_s) >> (speed <= standstill))


@pattern
def hand_guiding(enabled: TruthValue, moving: TruthValue, *, within_s: float = 0.0) -> Formula:
    """The robot moves only while the person holds the enabling device; it stops at most `within_s` after its release.

    Formula: `always(moving -> enabled)`, with a time `always(moving -> once[0:within_s](enabled))`. Scope: while the
    robot moves; if it has other modes, write `moving & guided`. Source: hand guiding, ISO 10218-1:2025 (5.10.3 in the
    edition of 2011); ISO/TS 15066:2016, 5.5.3.

    Raises:
        PatternError: a condition that is true for single instants only, or an argument of a wrong type.

    >>> from pytest_hricdv.monitor.build import signal
    >>> print(hand_guiding(signal("enabling_device"), (signal("arm_speed") > 0.001).hysteresis(0.004), within_s=0.2))
    always(arm_speed > 0.001 [hysteresis 0.004] -> once[0:0.2](enabling_device))
    """
    require_duration(enabled, "enabled")
    return always(require_duration(moving, "moving") >> (once(enabled, 0, within_s) if within_s else enabled))


def _limit(
    value: NumberValue,
    limit: NumberValue | float,
    transient_limit: NumberValue | float | None,
    transient_s: float | None,
    argument: str,
) -> Formula:
    if transient_limit is None and transient_s is None:
        return always((value > 0) >> (value <= limit))
    if transient_limit is None or transient_s is None:
        present = argument if transient_s is None else "transient_s"
        raise PatternError(present, f"expected both {argument} and transient_s, or neither")
    return always((value > 0) >> ((value <= transient_limit) & ~(value > limit).held_for(transient_s)))
