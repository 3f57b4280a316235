"""The physical world in the kernel's virtual time: it steps, freezes when nothing moves, and records signals."""

from __future__ import annotations

from collections.abc import Callable
from types import TracebackType
from typing import ClassVar, Self

from pytest_hricdv.runtime import Recorder
from sim.bystander import Bystander
from sim.engine import STEP_HZ, TICK_STEPS, PhysicsTime, SimulationError, steps_until, time_of
from sim.engines import known, new_engine
from sim.fingers import Fingers
from sim.geometry import Vector
from sim.gripper import FingerMotion, Gripper
from sim.layout import furnish
from sim.leg_supply import LegSupply, PressureSensor
from sim.mechanics import mechanics_of
from sim.person import Person
from sim.torso import Torso
from sim.whereabouts import Whereabouts

SPEED_DIGITS = 6
"""Arm speeds are recorded to a microradian per second: smaller changes are noise of a motor at constant speed, and each
recorded change wakes the monitors."""

REST_RAD_S = 1e-6
"""Joints slower than this are at rest. From 1e-7 to 1e-4 the records are the same (see REST_TICKS)."""

MOVING_RAD_S = 0.01
"""An arm that is faster moves: a twentieth of its speed."""

# Chosen: what turns round, as a leg that bounces, is slow for one tick. From 1 to 20 the records are the same (compare
# `bench.run(bench.concrete(bench.leg() * 2, seed))` of tests.hri at seeds 1 and 2); 20 skip a fifth less of the time.
REST_TICKS = 3
SETTLE_STEPS = STEP_HZ // 2
"""Before time 0 the robot settles into its motors for half a second. From 0 to 1 s the records are the same: it stands
where its motors hold it. Another description of the robot may not."""


class Watch:
    """A condition that a node waits for: `notify` is called once, at the first control tick at which it holds."""

    def __init__(self, condition: Callable[[], bool], notify: Callable[[], None]) -> None:
        self.condition = condition
        self.notify = notify


class World:
    """Torso, legs, table and person in a physics engine; a `runtime.World`.

    A context manager; one world at a time in a process.

    Args:
        recorder: receives the signals `arm_speed` (rad/s, the arm's fastest joint, each physics step), `arm_moving`,
            `leg_held`, `leg_torn` (pulled out of a hand that does not open), `hand_gripped` (a person's grip keeps the
            fingers from opening), `hand_closing`, and each physics step while closing `hand_distance` (m, the person's
            hand to the robot's palm and fingers) and `hand_contact_force` (N, with which the fingers press on the
            person's hand); and each control tick `leg_offset` (m, leg's middle to the handover place), `leg_height`
            (m, leg's middle above the floor), `leg_in_bin`, `leg_taken` (the person carries it), `hand_place` (see
            `sim.whereabouts`) and `arm_home`.
        freeze: skip steps while nothing can move. Messages and verdicts are the same without.
        fidelity: "dynamic" or "kinematic" (see `sim.mechanics`).
        engine: of physics (see `sim.engines`); the first one that is installed if it is empty.

    Raises:
        SimulationError: another world is still open, or there is no such fidelity or engine.
    """

    _open: ClassVar[World | None] = None

    def __init__(self, recorder: Recorder, *, freeze: bool = True, fidelity: str = "dynamic", engine: str = "") -> None:
        if World._open is not None:
            raise SimulationError("another world is open in this process: close it first")
        self._mechanics = mechanics_of(fidelity)
        self.engine_name = known(engine)
        self.engine = new_engine(self.engine_name)
        World._open = self
        self.fidelity = fidelity
        self._recorder = recorder
        self._freeze = freeze
        self._rest_ticks = 0
        self._frozen_steps = 0
        self._watches: list[Watch] = []
        self._triggered: list[Watch] = []
        self._signals: dict[str, float | bool | str] = {}
        self.time = PhysicsTime()
        try:
            self._build()
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Release all resources; may be called twice."""
        self.engine.close()
        if World._open is self:
            World._open = None

    @property
    def frozen_s(self) -> float:
        """Simulated time (s) that was skipped."""
        return self._frozen_steps / STEP_HZ

    def advance(self, target_us: int) -> int:
        """Advance physics to `target_us`, or to the first tick at which a watch holds; returns the time (us)."""
        last = steps_until(target_us)
        try:
            while self.time.step < last:
                if self._is_frozen():
                    self._skip_steps(last)
                else:
                    self._step(last - self.time.step)
                if self._triggered and self.time.now_us <= target_us:
                    self.person.follow()
                    return self.time.now_us
        except SimulationError as error:
            raise SimulationError(f"at {self.time.now_s:.4f} s: {error}") from error
        self.time.now_us = target_us
        self.person.follow()
        return target_us

    def observe(self) -> None:
        """Notify the nodes whose watches hold."""
        triggered, self._triggered = self._triggered, []
        for watch in triggered:
            watch.notify()

    def watch(self, condition: Callable[[], bool], notify: Callable[[], None]) -> Watch:
        """Call `notify` at the first control tick at which `condition` holds."""
        watch = Watch(condition, notify)
        self._watches.append(watch)
        self.unfreeze()
        return watch

    def unwatch(self, watch: Watch) -> None:
        """Remove a watch; without effect if it was notified already."""
        if watch in self._watches:
            self._watches.remove(watch)

    def unfreeze(self) -> None:
        """After a command: physics must step until everything is at rest again."""
        self._rest_ticks = 0

    def grasp_point(self) -> Vector:
        """Middle of the robot's grasp (m)."""
        return self._whereabouts.grasp_point()

    def signal(self, name: str, value: float | bool | str) -> None:
        """Record a signal's value from now on."""
        if self._signals.get(name) != value:  # most are what they were at the last tick
            self._signals[name] = value
            self._recorder.signal(self.time.now_s, name, value)

    def _build(self) -> None:
        engine = self.engine
        furnish(engine)
        self.torso = Torso(engine, self._mechanics.drive)
        self.fingers = Fingers(engine, self.torso.palm_pose(), self._mechanics.drive)
        self.person = Person(engine, self.time)
        self.legs = LegSupply(engine, self.time, self._mechanics.leg)
        self.pressure = PressureSensor(self.legs)
        self.gripper = Gripper(engine, self.torso, self.fingers, self.legs, self.person, self.signal)
        self.bystander = Bystander(engine, self.torso, self.fingers)
        self._whereabouts = Whereabouts(self.torso, self.legs, self.signal)
        settled = 0
        while settled < SETTLE_STEPS:
            settled += self._mechanics.advance(engine, SETTLE_STEPS - settled)
        self._speed_rad_s = 0.0
        self.signal("arm_speed", self._speed_rad_s)
        self.signal("arm_moving", False)
        self.signal("leg_held", False)
        self.signal("leg_torn", False)
        self._whereabouts.tick()
        self.signal("hand_closing", False)
        self.signal("hand_gripped", False)
        self.signal("hand_contact_force", 0.0)
        self.signal("hand_distance", self.gripper.human_distance())

    def _step(self, at_most: int) -> None:
        gripper = self.gripper
        if gripper.busy:
            gripper.before_step()
        made = self._mechanics.advance(self.engine, self._steps_at_once(at_most))
        self._record_speeds(made)
        if gripper.motion is not FingerMotion.NONE or self.legs.carried is not None:
            self.person.follow()  # otherwise nothing depends on the person before the next tick
        if gripper.motion is not FingerMotion.NONE:
            gripper.after_step()
        if self.time.step % TICK_STEPS == 0:
            self._tick()

    def _steps_at_once(self, at_most: int) -> int:
        """Up to the next tick, while nothing but physics depends on each step."""
        carries = self.legs.carried is not None and self.person.hand.moving
        if (carries or self.gripper.busy_each_step) and not self._mechanics.by_tick:
            return 1
        return min(TICK_STEPS - self.time.step % TICK_STEPS, at_most)

    def _record_speeds(self, made: int) -> None:
        """Count the steps that were made, and record the arm's speed, each at its time."""
        speeds = self.torso.arm_speeds()
        last = self.time.step + made
        for step, raw_rad_s in enumerate(speeds, last - len(speeds) + 1):
            speed_rad_s = round(raw_rad_s, SPEED_DIGITS)
            if speed_rad_s != self._speed_rad_s:
                self._speed_rad_s = speed_rad_s
                self._count(step - self.time.step)
                self.signal("arm_speed", speed_rad_s)
                self.signal("arm_moving", speed_rad_s > MOVING_RAD_S)
        self._count(last - self.time.step)

    def _tick(self) -> None:
        self.person.follow()
        self.gripper.tick()
        self.legs.tick()
        self.bystander.tick()
        self._whereabouts.tick()
        self._rest_ticks = self._rest_ticks + 1 if self._at_rest() else 0
        for watch in tuple(self._watches):
            if watch.condition():
                self._watches.remove(watch)
                self._triggered.append(watch)

    def _at_rest(self) -> bool:
        """True when nothing moves and no force changes."""
        return (
            not self._force_changes()
            and self.gripper.motion is FingerMotion.NONE
            and self.torso.arm_speed() < REST_RAD_S
            and self.legs.still()
        )

    def _force_changes(self) -> bool:
        """True while a force changes, or does not keep a leg where it is; a constant force moves no robot at rest."""
        held = self.legs.in_hand
        if held is not None and (self.person.pull_changing or held.slippery):
            return True
        return self.legs.carried is not None

    def _is_frozen(self) -> bool:
        return self._freeze and self._rest_ticks >= REST_TICKS and not self._force_changes()

    def _skip_steps(self, last: int) -> None:
        """Skip steps in which only the person moves, up to the tick at which a leg comes, or one that fell rests."""
        due = self.legs.changes_step
        upto = last if due is None else min(last, -(-due // TICK_STEPS) * TICK_STEPS)
        self._frozen_steps += upto - self.time.step
        self._count(upto - self.time.step)
        self.person.follow()
        if due is not None and upto >= due:
            self._tick()
            self.unfreeze()

    def _count(self, steps: int) -> None:
        self.time.step += steps
        self.time.now_us = time_of(self.time.step)
