"""The person as a node: enacts a script of commands and reacts to the robot's messages, not to the clock."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from controller.ports import HumanReady, LegReady, Request, TurnDone
from pytest_hricdv.runtime import Kernel, NodeBus
from sim.gaze import Gaze, head_pose, orientation_to
from sim.geometry import Vector
from sim.layout import AWAY_HAND_M, AWAY_HEAD_M, HANDOVER_M, REST_HAND_M, SEAT_HEAD_M, assembly_place
from sim.script import Step, check_script
from sim.world import World

PATIENCE_S = 60.0
"""A person waits this long for the robot's signal. Case study: `receivesignal`."""

TURN_PATIENCE_S = 150.0
"""How long a person waits for release or discard of an offered leg before the next request: longer than the robot's
longest turn, in which its sensors give no reading for up to 100 s."""

HOLDS_S = 15.0
"""A person who has a leg, and hears nothing of the robot for so long, takes it away: a turn is reported within 15 s
after the leg has left the robot's hand (R15). Who stood there with it was in the way of the next leg."""

LOOKS_S = 2.5
"""So often a person who waits notices whether a leg is in the own hand (chosen)."""

REST_OF_RUN_S = 1000.0
"""Longer than any run."""


class Human:
    """A person who enacts one command after the other; movements and speech take time.

    Args:
        world: holds the person's head and hand.
        bus: carries the robot's messages and the person's speech.
        kernel: virtual time.
        script: commands with their parameters (see `sim.script`); each is taken when the person begins it.
        patience_s: how long the person waits for the robot's signal.

    Raises:
        SimulationError: an unknown command, or a parameter that is missing or not finite; of a script that is produced
            step by step, in the person's node.
    """

    def __init__(
        self,
        world: World,
        bus: NodeBus,
        kernel: Kernel,
        script: Iterable[Step],
        patience_s: float = PATIENCE_S,
    ) -> None:
        self._world = world
        self._bus = bus
        self._kernel = kernel
        self._script = check_script(script)
        self._patience_s = patience_s
        self._ready = bus.subscribe(LegReady)
        self._ends = bus.subscribe(TurnDone)
        self._awaited_turn = 0  # the announced turn that is not over; 0 for none
        self._ended_turn = 0
        self._away = False
        self._silent = False
        self.done = False

    def enact(self) -> None:
        """The node's body: the whole script, then the end of the last turn; `done` is set after that.

        The node goes on to react to the robot: a leg that comes late is still taken and put down.
        """
        for command, parameters in self._script:
            self._handle_turn_ends()
            if command == "tell leg":
                self._request_leg(parameters)
            elif not self._away:
                self._enact_command(command, parameters)
        self.await_turn_end()
        self.done = True
        while True:
            end = self._ends.wait(REST_OF_RUN_S)
            if end is not None:
                self._turn_ended(end)

    def say(self, message: Request | HumanReady) -> None:
        """Say something now, whether it is time for it or not."""
        self._bus.publish(message)

    def fall_silent(self) -> None:
        """Keep the next "ready" to oneself."""
        self._silent = True

    def _enact_command(self, command: str, parameters: Mapping[str, float]) -> None:
        if command == "receivesignal":
            self._receive_signal()
        elif command == "tell humanReady":
            self._kernel.sleep(parameters["voice_s"])
            if not self._silent:
                self.say(HumanReady())
            self._silent = False
        elif command == "bored":
            self._walk_off()
        elif command.startswith("set_param gaze"):
            self._look(parameters)
        elif command.startswith("set_param location"):
            self._reach(parameters)
        elif command == "set_param pressure = 1":
            self._world.person.pull(parameters["pull_n"])
            self._world.person.grip(parameters["grip_s"])
        else:
            self._stop_forces()

    def _request_leg(self, parameters: Mapping[str, float]) -> None:
        self.await_turn_end()
        if self._away:
            self._away = False
            self._move(head=SEAT_HEAD_M, hand=REST_HAND_M)
        self._kernel.sleep(parameters["voice_s"])
        self._ready.clear()  # an earlier announcement does not answer this request
        self.say(Request())
        self._move(hand=(parameters["rest_x_m"], parameters["rest_y_m"], parameters["rest_z_m"]))

    def _receive_signal(self) -> None:
        ready = self._ready.wait(self._patience_s)
        self._handle_turn_ends()
        if ready is not None and ready.turn > self._ended_turn:
            self._awaited_turn = ready.turn

    def _look(self, parameters: Mapping[str, float]) -> None:
        gaze = Gaze(parameters["offset_m"], parameters["distance_m"], parameters["angle_deg"])
        place, turn = head_pose(gaze, parameters["side"], self._leg_place())
        self._kernel.sleep(self._world.person.head.move(place, turn))

    def _reach(self, parameters: Mapping[str, float]) -> None:
        x, y, z = self._leg_place()
        self._move(hand=(x + parameters["dx_m"], y + parameters["dy_m"], z + parameters["dz_m"]))

    def _walk_off(self) -> None:
        self._stop_forces()
        self._set_leg_down()
        self._move(head=AWAY_HEAD_M, hand=AWAY_HAND_M)
        self._away = True

    def _handle_turn_ends(self) -> None:
        """Handle ends of turns that have been reported meanwhile."""
        while (end := self._ends.poll()) is not None:
            self._turn_ended(end)

    def await_turn_end(self) -> None:
        """Wait for the end of the announced turn, if there is one. A second time right after it does nothing."""
        self._handle_turn_ends()
        deadline_s, holds_since_s = self._kernel.now_s + TURN_PATIENCE_S, math.inf
        while self._awaited_turn and self._kernel.now_s < deadline_s:
            end = self._ends.wait(min(LOOKS_S, deadline_s - self._kernel.now_s))
            if end is not None:
                self._turn_ended(end)
            elif self._world.legs.carried is None:
                holds_since_s = math.inf
            else:
                holds_since_s = min(holds_since_s, self._kernel.now_s)
                if self._kernel.now_s - holds_since_s >= HOLDS_S:
                    self._sit_back()
            self._handle_turn_ends()
        if self._awaited_turn:  # the robot's report was not heard: the person takes the turn for ended
            self._awaited_turn = 0
            self._sit_back()
            self._handle_turn_ends()

    def _turn_ended(self, end: TurnDone) -> None:
        self._ended_turn = max(self._ended_turn, end.turn)
        if end.turn >= self._awaited_turn:
            self._awaited_turn = 0
        self._sit_back()

    def _sit_back(self) -> None:
        self._stop_forces()
        if not self._away:
            self._set_leg_down()
            self._move(head=SEAT_HEAD_M, hand=REST_HAND_M)

    def _set_leg_down(self) -> None:
        """Put each received leg down on the person's side of the table."""
        legs = self._world.legs
        while (leg := legs.carried) is not None:
            place = assembly_place(legs.received)
            hand, at = self._world.person.hand.pose()[0], leg.pose()[0]
            self._move(hand=(place[0] + hand[0] - at[0], place[1] + hand[1] - at[1], place[2] + hand[2] - at[2]))
            self._world.unfreeze()
            legs.set_down(leg)

    def _stop_forces(self) -> None:
        self._world.person.pull(0.0)
        self._world.person.grip(0.0)

    def _move(self, *, head: Vector | None = None, hand: Vector | None = None) -> None:
        person = self._world.person
        head_s = 0.0 if head is None else person.head.move(head, orientation_to(head, HANDOVER_M))
        hand_s = 0.0 if hand is None else person.hand.move(hand)
        self._kernel.sleep(max(head_s, hand_s))

    def _leg_place(self) -> Vector:
        return self._world.legs.place()
