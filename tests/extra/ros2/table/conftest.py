"""The testbench of the table assembly, with nodes of ROS 2 instead of the controller: all else is as it is there."""

from __future__ import annotations

import importlib.util
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
TABLE = HERE.parents[3] / "conftest.py"
LIMIT_S = 900.0


def pytest_hricdv_testbench(config: Any) -> Any:
    from pytest_hricdv.testbench import Ros2

    spec = importlib.util.spec_from_file_location("table_testbench", TABLE)
    assert spec is not None
    assert spec.loader is not None
    table = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(table)
    return replace(
        table.pytest_hricdv_testbench(config),
        name="table-assembly-ros2",
        code=("handover_nodes",),
        ros2=Ros2(),
        run=run,
    )


def run(run: Any) -> Any:
    """Runs one test: the nodes in the simulated workshop."""
    from controller.ports import TableDone
    from pytest_hricdv.testbench import Outcome, RosNode
    from sim.script import check_script
    from sim.turns import ended_turns, observed_turns
    from sim.workshop import Workshop

    test = run.test
    check_script([(each.command, each.parameters) for each in test.actions if each.disturbance is None])
    script = ((action.command, action.parameters) for action in run.actions())
    ports, outage_turn = (run.kernel, run.bus, run.recorder), int(test.run["outage_turn"])
    fidelity = run.fidelity or "dynamic"
    with Workshop(
        *ports, script, seed=test.seed, outage_turn=outage_turn, fidelity=fidelity, engine=run.engine
    ) as shop:
        run.set_disturbance_target(shop)
        run.set_idle_handler(shop.human.await_turn_end)
        tables = run.bus.subscribe(TableDone)
        shop.start(lambda: tables.wait(LIMIT_S))
        parameters = [{"sensing_timeout_s": float(test.run["sensing_timeout_s"])}]
        ros = run.ros2(
            RosNode(entry="handover_nodes.voice:main"),
            RosNode(entry="handover_nodes.sensors:main"),
            RosNode(entry="handover_nodes.robot:main", parameters=parameters),
        )
        connect(run, ros.node("workshop"), shop)
        ended = run.go(LIMIT_S)
        commands, messages = [action.command for action in run.enacted.actions], run.recorder.messages
        turns = observed_turns(messages)
        ended_as_planned = ended_turns(commands, run.action_times_s, messages)
        cross = {"decision": turns, "handover": [(*turn, outcome) for turn, outcome in ended_as_planned]}
        return Outcome(ended, tuple(outcome for _, outcome in turns), shop.world.frozen_s, cross, fidelity)


def connect(run: Any, node: Any, shop: Any) -> None:
    """The workshop's devices as ROS 2 has them, and what the robot says as the person hears it."""
    from std_msgs.msg import Bool, String

    from controller.ports import HumanReady, LegReady, PlanningError, Reading, Request, State, TableDone, TurnDone

    robot = run.bus.port("robot")

    def forward(words: Any, publish: Any) -> None:
        """Publish what is heard; words are heard from now on, also before the node begins."""

        def forwarding() -> None:
            while True:
                message = words.wait(LIMIT_S)
                if message is not None:
                    publish(message)

        run.kernel.spawn("forward", forwarding)

    def microphone(kind: Any, phrase: str) -> None:
        publisher = node.publisher("/microphone", String)
        forward(run.bus.subscribe(kind), lambda _: publisher.publish(String(data=phrase)))

    def speaker(message: Any) -> None:
        word, _, rest = message.data.partition(" ")
        if word == "table":
            robot.publish(TableDone(**json.loads(rest)))
        else:
            turn, _, outcome = rest.partition(" ")
            robot.publish(LegReady(int(turn)) if word == "leg" else TurnDone(int(turn), outcome))

    def trackers() -> None:
        """The sensors measure while somebody listens to the trackers."""
        publishers = {name: node.publisher(f"/trackers/{name}", Bool) for name in ("gaze", "pressure", "location")}
        while True:
            while not publishers["location"].get_subscription_count():
                run.kernel.sleep(0.02)
            readings = run.bus.subscribe(Reading)
            while publishers["location"].get_subscription_count():
                reading = readings.wait(0.02)
                for name, publisher in publishers.items() if reading is not None else ():
                    publisher.publish(Bool(data=getattr(reading, name)))
                run.kernel.sleep(0.001)  # who has heard enough has said so by then
            readings.close()

    arrived = node.publisher("/arm/arrived", Bool)

    def move_arm(message: Any) -> None:
        try:
            path = shop.robot.arm.plan([tuple(point.positions) for point in message.points], 0.25)
            arrived.publish(Bool(data=shop.robot.arm.follow(path)))
        except PlanningError:
            arrived.publish(Bool(data=False))

    def move_fingers(request: Any, response: Any) -> Any:
        response.success = shop.robot.hand.close() if request.data else shop.robot.hand.open()
        return response

    def holds(_: Any, response: Any) -> Any:
        response.success = shop.robot.hand.holds()
        return response

    node.serve("/hand/close", "std_srvs/srv/SetBool", move_fingers)
    node.serve("/hand/holds", "std_srvs/srv/Trigger", holds)
    microphone(Request, "Give me a leg")
    microphone(HumanReady, "I am ready")
    forward(node.subscribe("/speaker", String), speaker)
    forward(node.subscribe("/robot/state", String), lambda message: robot.publish(State(message.data)))
    forward(node.subscribe("/arm/trajectory", "trajectory_msgs/msg/JointTrajectory"), move_arm)
    run.kernel.spawn("trackers", trackers)
