"""The person as a node: enacts a script of commands, and reacts to what the robot says rather than to the clock."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from controller.ports import HumanReady, LegReady, Request, TurnDone
from pytest_hricdv.runtime import Kernel, NodeBus
from sim.engine import Vector
from sim.gaze import Gaze, head_for, looking
from sim.places import AWAY_HAND_M, AWAY_HEAD_M, HANDOVER_M, REST_HAND_M, SEAT_HEAD_M, assembly_place
from sim.script import Script, checked
from sim.world import World

PATIENCE_S = 60.0
"""A person waits this long for the robot's signal. Case study: `receivesignal`."""

TURN_PATIENCE_S = 150.0
"""A person to whom a leg is held out waits this long for release or discard before asking for another one: longer than
the robot's longest turn, in which its sensors are silent up to 100 s."""

REST_OF_RUN_S = 1000.0
"""Longer than any run."""


class Human:
    """A person who does one command after the other; movements and speech take their time.

    Args:
        world: whose head and hand are the person's.
        bus: hears the robot, and stands for the speech recognizer.
        kernel: keeps the time.
        script: commands with their parameters (see `sim.script`).
        patience_s: how long the person waits for the robot's signal.
        acting: told the number of each command (from 0) when its turn comes.

    Raises:
        SimulationError: an unknown command, or a parameter that is missing or not finite.
    """

    def __init__(
        self,
        world: World,
        bus: NodeBus,
        kernel: Kernel,
        script: Sequence[tuple[str, Mapping[str, float]]],
        patience_s: float = PATIENCE_S,
        acting: Callable[[int], None] | None = None,
    ) -> None:
        self._world = world
        self._bus = bus
        self._kernel = kernel
        self._script: Script = checked(script)
        self._patience_s = patience_s
        self._acting = acting or (lambda number: None)
        self._ready = bus.subscribe(LegReady)
        self._ends = bus.subscribe(TurnDone)
        self._awaited_turn = 0  # of the leg that was announced to the person and is not over; 0 for none
        self._ended_turn = 0
        self._gone = False
        self.done = False

    def enact(self) -> None:
        """The node's body: the whole script, then the end of the last turn; `done` from there on.

        The body goes on to react to the robot: a leg that comes late is still taken and set down.
        """
        for number, (command, parameters) in enumerate(self._script):
            self._acting(number)
            self._notice()
            if command == "tell leg":
                self._tell_leg(parameters)
            elif not self._gone:
                self._enact_one(command, parameters)
        self._await_turn_end()
        self.done = True
        while True:
            end = self._ends.wait(REST_OF_RUN_S)
            if end is not None:
                self._turn_ended(end)

    def _enact_one(self, command: str, parameters: Mapping[str, float]) -> None:
        if command == "receivesignal":
            self._receive_signal()
        elif command == "tell humanReady":
            self._kernel.sleep(parameters["voice_s"])
            self._bus.publish(HumanReady())
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
            self._let_be()

    def _tell_leg(self, parameters: Mapping[str, float]) -> None:
        self._await_turn_end()
        if self._gone:
            self._gone = False
            self._move(head=SEAT_HEAD_M, hand=REST_HAND_M)
        self._kernel.sleep(parameters["voice_s"])
        self._ready.clear()  # what was announced for an earlier leg is no answer to this request
        self._bus.publish(Request())
        self._move(hand=(parameters["rest_x_m"], parameters["rest_y_m"], parameters["rest_z_m"]))

    def _receive_signal(self) -> None:
        ready = self._ready.wait(self._patience_s)
        self._notice()
        if ready is not None and ready.turn > self._ended_turn:
            self._awaited_turn = ready.turn

    def _look(self, parameters: Mapping[str, float]) -> None:
        gaze = Gaze(parameters["offset_m"], parameters["distance_m"], parameters["angle_deg"])
        place, turn = head_for(gaze, parameters["side"], self._leg_place())
        self._kernel.sleep(self._world.person.head.move(place, turn))

    def _reach(self, parameters: Mapping[str, float]) -> None:
        x, y, z = self._leg_place()
        self._move(hand=(x + parameters["dx_m"], y + parameters["dy_m"], z + parameters["dz_m"]))

    def _walk_off(self) -> None:
        self._let_be()
        self._take_leg_along()
        self._move(head=AWAY_HEAD_M, hand=AWAY_HAND_M)
        self._gone = True

    def _notice(self) -> None:
        """React to the end of a turn, if it came meanwhile."""
        while (end := self._ends.poll()) is not None:
            self._turn_ended(end)

    def _await_turn_end(self) -> None:
        """Wait for the end of the turn whose leg was announced, if there is one and it is not over."""
        self._notice()
        deadline_s = self._kernel.now_s + TURN_PATIENCE_S
        while self._awaited_turn and self._kernel.now_s < deadline_s:
            end = self._ends.wait(deadline_s - self._kernel.now_s)
            if end is not None:
                self._turn_ended(end)
        self._awaited_turn = 0

    def _turn_ended(self, end: TurnDone) -> None:
        self._ended_turn = max(self._ended_turn, end.turn)
        if end.turn >= self._awaited_turn:
            self._awaited_turn = 0
        self._let_be()
        if not self._gone:
            self._take_leg_along()
            self._move(head=SEAT_HEAD_M, hand=REST_HAND_M)

    def _take_leg_along(self) -> None:
        """Set a leg that was released to the hand down on the own side of the table."""
        legs = self._world.legs
        leg = legs.carried
        if leg is None:
            return
        place = assembly_place(legs.received)
        hand, at = self._world.person.hand.pose()[0], leg.pose()[0]
        self._move(hand=(place[0] + hand[0] - at[0], place[1] + hand[1] - at[1], place[2] + hand[2] - at[2]))
        self._world.disturb()
        legs.set_down()

    def _let_be(self) -> None:
        self._world.person.pull(0.0)
        self._world.person.grip(0.0)

    def _move(self, *, head: Vector | None = None, hand: Vector | None = None) -> None:
        person = self._world.person
        head_s = 0.0 if head is None else person.head.move(head, looking(head, HANDOVER_M))
        hand_s = 0.0 if hand is None else person.hand.move(hand)
        self._kernel.sleep(max(head_s, hand_s))

    def _leg_place(self) -> Vector:
        return self._world.legs.current.pose()[0]
