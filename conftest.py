"""The testbench of the table assembly. For your own robot, copy the testbench in docs/tutorial.md."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from pytest_hricdv.testbench import Body, Camera, Outcome, Run, Testbench
    from sim.world import World

HERE = Path(__file__).parent
POSES = tuple("".join(bits) for bits in product("01", repeat=3))
BOREDOM = ("bored", "not_bored")
LIMIT_S = 900.0
"""No run needs as long: one that does has hung. It is well above the 300 s of R5, so that a table can be late."""
FIDELITY = "dynamic"
"""Unless --hri-fidelity=kinematic: no masses and forces, for planner and logic only, and many times faster."""
TURN_DONE = "on(turn_done) & turn_done.outcome"
"""The end of a turn, up to its outcome."""
ENGINE_TOLERANCES = {"R1": 0.084, "R2": 0.005, "R3": 0.005, "R4": 0.0005}
"""By how much margins may differ between engines: by a control tick on either side of a deadline (s), by 5 mm where a
leg leaves the hand and in how near a closing hand comes (m), by a five-hundredth of an arm's speed limit (rad/s);
docs/own-world.md."""


def pytest_report_header(config: pytest.Config) -> list[str]:
    """Which planner leads the arm around obstacles, where it is not the usual one."""
    if not config.getoption("hri_suite"):
        return []
    from sim.detours import has_ompl

    return [] if has_ompl() else ["table: detours of the arm by sim/rrt_connect.py (OMPL is not installed)"]


def pytest_hricdv_testbench(config: pytest.Config) -> Testbench:
    """Hands the testbench over. Imports stay inside: a run without a suite pays for none of this."""
    from controller.journal import OUTCOMES, RELEASED
    from controller.machine import STATES, TRANSITIONS
    from controller.ports import MESSAGES
    from pytest_hricdv.testbench import (
        ActionMapping,
        BeliefSpace,
        Concretization,
        CrossProduct,
        Delay,
        Disturbance,
        Drop,
        Duplicate,
        Field,
        Film,
        InteractiveAgent,
        Model,
        ModelOracle,
        People,
        PerceptMapping,
        Signal,
        Simulation,
        Sometimes,
        StateField,
        Suites,
        Testbench,
        Uniform,
    )
    from sim import disturbances
    from sim.events import EVENTS
    from sim.turns import planned_turns
    from sim.whereabouts import HAND_PLACES

    at_leg, off, side = Uniform(-0.03, 0.03, "m"), Uniform(0.5, 0.75, "m"), Uniform(-1.0, 1.0, "left or right")
    looks = {"offset_m": Uniform(0.1, 0.2, "m"), "distance_m": Uniform(0.5, 0.6, "m"), "side": side}
    looks_away = {"offset_m": Uniform(0.2, 0.5, "m"), "distance_m": Uniform(0.6, 0.8, "m"), "side": side}
    # Where the hand rests while the robot fetches: over the shared table, which includes the pickup place.
    rests = {
        "rest_x_m": Uniform(0.475, 0.78, "m"),
        "rest_y_m": Uniform(-0.5, 0.1, "m"),
        "rest_z_m": Uniform(0.46, 0.7, "m"),
    }
    where = Uniform(0.0, 4.0, "place", open_high=True)
    beside, soon, for_long = Uniform(-0.08, 0.08, "m"), Uniform(0.0, 10.0, "s"), Uniform(5.0, 90.0, "s")
    return Testbench(
        name="table-assembly",
        model=Model(HERE / "models_bdi" / "table_assembly.mas2j"),
        beliefs=BeliefSpace(
            start=("leg1", "leg2", "leg3", "leg4"),
            groups={"boredom": BOREDOM}
            | {f"leg {leg}": tuple(f"m{pose}l{leg}" for pose in POSES) for leg in (1, 2, 3, 4)},
            id_groups=("boredom",),
            default_beliefs=("not_bored",),
        ),
        concretization=Concretization(
            commands={
                "tell leg": {"voice_s": Uniform(3.0, 5.0, "s"), **rests},
                "receivesignal": {},
                "set_param gaze = 1": {"angle_deg": Uniform(15.0, 40.0, "deg", open_high=True), **looks},
                "set_param gaze = 0": {"angle_deg": Uniform(40.0, 50.0, "deg"), **looks_away},
                "set_param location = 1": {"dx_m": at_leg, "dy_m": at_leg, "dz_m": at_leg},
                "set_param location = 0": {"dx_m": off, "dy_m": off, "dz_m": off},
                # Now and then a person grips the robot's fingers together with the leg.
                "set_param pressure = 1": {
                    "pull_n": Uniform(6.0, 10.0, "N"),
                    "grip_s": Sometimes(0.02, Uniform(4, 14, "s")),
                },
                "set_param pressure = 0": {},
                "tell humanReady": {"voice_s": Uniform(2.0, 3.0, "s")},
                "bored": {},
            },
            run={
                "sensing_timeout_s": Uniform(10.0, 100.0, "s"),
                "outage_turn": Sometimes(0.04, Uniform(1.0, 5.0, "turn", open_high=True)),
            },
        ),
        requirements=HERE / "tests" / "hri" / "requirements.toml",
        messages=(*MESSAGES, *EVENTS),
        signals={
            "leg_held": bool,
            "leg_torn": bool,
            "leg_offset": Signal(float, unit="m"),
            "leg_height": Signal(float, unit="m"),
            "leg_in_bin": bool,
            "leg_taken": bool,
            "arm_home": bool,
            "hand_place": Signal(str, values=HAND_PLACES),
            "hand_closing": bool,
            "hand_gripped": bool,
            "hand_distance": Signal(float, unit="m", sampled_while="hand_closing"),
            "hand_contact_force": Signal(float, unit="N"),
            "arm_speed": Signal(float, unit="rad/s"),
            "arm_moving": bool,
        },
        state=StateField(
            "state.name",
            transitions=tuple(
                (state, following) for (state, _), following in TRANSITIONS.items() if following in STATES
            ),
        ),
        fields={"state.name": Field(values=tuple(STATES)), "turn_done.outcome": Field(values=OUTCOMES)},
        code=("controller",),
        run=run,
        outcome_label="legs",
        # What the robot should do, by its agent in the model. Times are from when the agent is ready for it.
        oracle=ModelOracle(
            agent="robot_code",
            percepts=(
                PerceptMapping("leg_wanted", "on(request)", source="human"),
                PerceptMapping("human_ready", "on(human_ready)", source="human"),
                PerceptMapping("reading(Gaze, Pressure, Location)", "on(reading)", source="sensors"),
            ),
            actions=(
                ActionMapping("@p3", "on(state) & state == 'Move_hand'", within_s=(0.0, 0.1)),
                ActionMapping("close_hand", "rise(hand_closing)", within_s=(0.0, 15.0)),
                ActionMapping(
                    "hold_leg", "rise(leg_held)", within_s=(0.5, 4.0), fails="fall(hand_closing) & !leg_held"
                ),
                ActionMapping("offer(Turn)", "on(leg_ready)", within_s=(3.0, 10.0)),
                ActionMapping("@p5", "on(state) & state == 'Wait0'", within_s=(0.0, 0.3)),
                ActionMapping("@p6", "on(state) & state == 'Timeout2'", within_s=(0.0, 0.1)),
                ActionMapping("reading_wanted", "on(state) & state == 'Sensing'", within_s=(1.9, 2.1)),
                ActionMapping("@p7", "on(state) & state == 'Timeout3'", within_s=(0.0, 0.1)),
                ActionMapping("@p8", "on(state) & state == 'Decide'", within_s=(0.0, 0.1)),
                ActionMapping("@p10", "on(state) & state == 'Release'", within_s=(0.0, 0.1)),
                ActionMapping("@p12", "on(state) & state == 'Discard'", within_s=(0.0, 1.0)),
                ActionMapping("release", "fall(leg_held) & once(on(request))", within_s=(0.0, 20.0)),
                ActionMapping("drop", "fall(leg_held) & once(on(request))", within_s=(3.0, 8.0)),
                ActionMapping("report_turn(Turn, Outcome)", "on(turn_done)", within_s=(3.0, 15.0)),
                ActionMapping("report_table", "on(table_done)", within_s=(0.0, 0.1)),
            ),
            # A person has 60 polls of 0.25 s to say "ready".
            limits={
                "patience_for_human": 15.0,
                "listening_step": 15.0,
                "patience_for_sensors": "sensing_timeout_s",
                "sensing_step": "sensing_timeout_s",
            },
            # It knows nobody in the arm's way, no leg that leaves a closed hand, and nobody who holds the fingers shut.
            until="on(way_blocked) | on(fingers_held) | rise(leg_torn)",
        ),
        disturbances={
            "leg_late": Disturbance({"for_s": Uniform(1.0, 120.0, "s")}, disturbances.leg_late),
            "leg_displaced": Disturbance({"dx_m": beside, "dy_m": beside}, disturbances.leg_displaced),
            # A leg weighs 4.9 N: a hand that holds it with less loses it at once, with more when somebody pulls.
            "leg_slips": Disturbance({"after_s": soon, "grasp_n": Uniform(1.0, 4.5, "N")}, disturbances.leg_slips),
            "leg_loose": Disturbance({"after_s": soon, "grasp_n": Uniform(5.0, 10.0, "N")}, disturbances.leg_slips),
            "leg_taken": Disturbance({"after_s": soon, "next_s": Uniform(3.0, 60.0, "s")}, disturbances.leg_taken),
            "leg_pulled_out": Disturbance(
                {"after_s": soon, "pull_n": Uniform(16.0, 30.0, "N")}, disturbances.leg_pulled_out
            ),
            "leg_in_hand": Disturbance({}, disturbances.leg_in_hand),
            "somebody_in_the_way": Disturbance(
                {"place": where, "after_s": Uniform(0.0, 30.0, "s"), "for_s": for_long},
                disturbances.somebody_in_the_way,
            ),
            "somebody_steps_in": Disturbance(
                {"place": where, "near_m": Uniform(0.25, 0.6, "m"), "for_s": for_long}, disturbances.somebody_steps_in
            ),
            "hand_held_shut": Disturbance({"grip_s": Uniform(20.0, 60.0, "s")}, disturbances.hand_held_shut),
            "hand_held_open": Disturbance({"after_s": soon, "for_s": for_long}, disturbances.hand_held_open),
            "sensors_silent": Disturbance({"for_s": Uniform(5.0, 150.0, "s")}, disturbances.sensors_silent),
            "sensors_late": Disturbance({"late_s": Uniform(0.5, 110.0, "s")}, disturbances.sensors_late),
            "sensors_stuck": Disturbance({"for_s": Uniform(5.0, 150.0, "s")}, disturbances.sensors_stuck),
            "gaze_flips": Disturbance({}, disturbances.gaze_flips),
            "pressure_flips": Disturbance({}, disturbances.pressure_flips),
            "location_flips": Disturbance({}, disturbances.location_flips),
            "says_ready": Disturbance({"after_s": Uniform(0.0, 15.0, "s")}, disturbances.says_ready),
            "asks_again": Disturbance({"after_s": Uniform(0.0, 40.0, "s")}, disturbances.asks_again),
            "falls_silent": Disturbance({}, disturbances.falls_silent),
            "request_lost": Drop("request"),
            "request_doubled": Duplicate("request", Uniform(0.1, 40.0, "s")),
            "offer_lost": Drop("leg_ready"),
            "offer_late": Delay("leg_ready", Uniform(1.0, 20.0, "s")),
            "ready_lost": Drop("human_ready"),
            "ready_late": Delay("human_ready", Uniform(1.0, 20.0, "s")),
            "end_lost": Drop("turn_done"),
        },
        people=People(
            agents=(
                InteractiveAgent(
                    agent="human",
                    percepts=(
                        PerceptMapping("leg_ready", "on(leg_ready)", source="robot_code"),
                        PerceptMapping("leg_released", f"{TURN_DONE} == 'released'", source="robot_code"),
                        PerceptMapping("leg_discarded", f"{TURN_DONE} != 'released'", source="robot_code"),
                    ),
                ),
            ),
        ),
        suites=Suites(by_hand=HERE / "tests" / "hri" / "by_hand.toml"),
        simulation=Simulation(
            fidelities=("dynamic", "kinematic"),
            engines={"pybullet": "sim.bullet.client", "mujoco": "sim.mujoco.library"},
            engine_tolerances=ENGINE_TOLERANCES,
            film=Film(
                camera=camera,
                moments={"request": "request", "grasp": "leg_held", "offer": "leg_ready", "decision": "reading"},
                state="state.name",
                bodies=bodies,
            ),
        ),
        cross={
            "decision": CrossProduct(
                {"reading": (*POSES, "none"), "outcome": OUTCOMES},
                impossible={(pose, out): "a turn that timed out has none" for pose in POSES for out in OUTCOMES[2:]},
                illegal={(pose, RELEASED): "somebody was not ready" for pose in (*POSES[:-1], "none")},
            ),
            "handover": CrossProduct(
                {
                    "legs": tuple("1234"),
                    "boredom": ("bored", "not_bored"),
                    "GPL": (*POSES, "none"),
                    "outcome": OUTCOMES,
                },
                planned=planned_turns,
            ),
        },
    )


def camera(world: World) -> Camera:
    """Puts up a camera, for `--hri-film`."""
    from sim.film import Camera

    return Camera(world)


def bodies(world: World) -> list[Body]:
    """The shapes of the workshop, for `--hri-mcap`."""
    from sim.film import bodies

    return bodies(world)


def run(run: Run) -> Outcome:
    """Runs one test: the real controller in the simulated workshop."""
    from controller import machine
    from controller.robot import Robot
    from controller.settings import Settings
    from pytest_hricdv.testbench import Outcome
    from sim.script import check_script
    from sim.turns import ended_turns, observed_turns
    from sim.workshop import Workshop

    test = run.test
    # What is known is checked before the run; each action is taken when the person is free for it.
    check_script([(act.command, act.parameters) for act in test.actions if act.disturbance is None])
    script = ((action.command, action.parameters) for action in run.actions())
    ports, outage_turn = (run.kernel, run.bus, run.recorder), int(test.run["outage_turn"])
    fidelity = run.fidelity or FIDELITY
    shop = Workshop(*ports, script, seed=test.seed, outage_turn=outage_turn, fidelity=fidelity, engine=run.engine)
    with shop:

        def control() -> None:
            # All of the code under test is called in here: only what runs in this node is measured.
            settings = Settings(sensing_timeout_s=test.run["sensing_timeout_s"])
            machine.run(Robot(run.bus.port("robot"), shop.robot.clock, shop.robot.arm, shop.robot.hand, settings))

        run.set_disturbance_target(shop)
        run.set_idle_handler(shop.human.await_turn_end)
        shop.start(run.measured(control))
        ended = run.go(LIMIT_S)
        commands, messages = [action.command for action in run.enacted.actions], run.recorder.messages
        turns = observed_turns(messages)
        legs = tuple(outcome for _, outcome in turns)
        ended_as_planned = ended_turns(commands, run.action_times_s, messages)
        cross = {"decision": turns, "handover": [(*turn, outcome) for turn, outcome in ended_as_planned]}
        return Outcome(ended, legs, shop.world.frozen_s, cross, fidelity)
