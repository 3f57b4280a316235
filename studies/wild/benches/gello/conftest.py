import sys
from dataclasses import dataclass
from pathlib import Path
from unittest.mock import MagicMock

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Testbench, Uniform, VirtualTime

HERE = Path(__file__).parent
sys.modules.update(dict.fromkeys(("tyro", "zmq", "termcolor", "omegaconf", "dynamixel_sdk", *(
    f"dynamixel_sdk.{name}" for name in ("group_sync_read", "group_sync_write", "packet_handler", "port_handler", "robotis_def"))),
    MagicMock()))


@dataclass(frozen=True)
class Told:
    """The arm is told where to go: how far it is from there, at its farthest joint."""

    away_rad: float


def pytest_hricdv_testbench(config):
    angle = {"rad": Uniform(0.4, 0.79, "rad"), "for_s": Uniform(0.5, 2.0, "s")}
    return Testbench(
        name="gello",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(start=("begins_left", "begins_right", "begins_far"),
                            groups={"arm": ("slow", "quick")}),
        concretization=Concretization(commands={
            "arm quick": {}, "arm slow": {}, "hold left": angle, "hold right": angle, "hold far": angle,
            "start": {"for_s": Uniform(0.5, 3.0, "s")}}),
        requirements=HERE / "requirements.toml",
        messages=(Told,),
        signals={"held_far": bool},
        code=("experiments.run_env", "gello.env", "gello.utils.control_utils"),
        time=VirtualTime(apis=("time",), allowed_endings=("early",)),
        run=run,
    )


def run(run):
    import numpy
    from experiments import run_env
    from gello.agents import gello_agent

    leader, arm, limit = numpy.zeros(7), numpy.zeros(7), [0.06]

    class Arm:
        num_dofs = lambda self: 7

        def command_joint_state(self, joints):
            run.bus.port("arm").publish(Told(float(abs(joints - arm).max())))
            arm[:] += numpy.clip(joints - arm, -limit[0], limit[0])

        def get_observations(self):
            keys = ("joint_positions", "joint_velocities", "ee_pos_quat", "gripper_position")
            return dict.fromkeys(keys, arm.copy())

    class Leader:
        def __init__(self, port, start_joints):
            pass

        act = lambda self, observations: leader.copy()

    run_env.ZMQClientRobot = lambda port, host: Arm()
    gello_agent.GelloAgent = Leader

    def program():
        try:
            run_env.main(run_env.Args(agent="gello", gello_port="/dev/gello", start_joints=(0.0,) * 7))
        except SystemExit:
            pass

    def person():
        run.recorder.signal(0.0, "held_far", False)
        run.kernel.sleep(0.1)
        for action in run.actions():
            verb, _, what = action.command.partition(" ")
            if verb == "arm":
                limit[0] = 0.06 if what == "quick" else 0.005  # rad in 10 ms
            elif verb == "hold":
                leader[2] = {"left": 1.0, "right": -1.0, "far": 3.0}[what] * action.parameters["rad"]
                run.recorder.signal(run.kernel.now_s, "held_far", what == "far")
            elif verb == "start":
                run.kernel.spawn("program", run.measured(program))
            run.kernel.sleep(action.parameters.get("for_s", 0.0))
        run.kernel.stop("the person has left")

    run.kernel.spawn("person", person)
    return Outcome(run.go(limit_s=60.0))
