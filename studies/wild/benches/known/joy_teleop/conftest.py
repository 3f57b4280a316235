from pathlib import Path

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Ros2, RosNode, Testbench, Uniform

HERE = Path(__file__).parent
COMMANDS = ("hold left", "hold right", "let_go left", "let_go right", "push stick", "push zero")
BUTTONS = {"left": 4, "right": 5}
DRIVE = {"type": "topic", "interface_type": "geometry_msgs/msg/Twist", "topic_name": "cmd_vel", "deadman_buttons": [4, 5],
         "axis_mappings": {"linear-x": {"axis": 1, "scale": 0.5, "offset": 0.0}}}  # as in its config/joy_teleop_example.yaml


def flat(table, prefix):
    for key, value in table.items():
        yield from flat(value, f"{prefix}.{key}") if isinstance(value, dict) else [(f"{prefix}.{key}", value)]


def pytest_hricdv_testbench(config):
    return Testbench(
        name="joy_teleop",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(
            start=("one_drive", "two_drives"), groups={"manner": ("holds_both", "holds_one", "lets_one_go", "forgets")}
        ),
        concretization=Concretization(commands={name: {"for_s": Uniform(0.3, 2.5, "s")} for name in COMMANDS}),
        requirements=HERE / "requirements.toml",
        messages=(),
        signals={"speed": float, "held": bool, "pushed": bool},
        code=("joy_teleop.joy_teleop",),
        ros2=Ros2(topics={"/cmd_vel": "geometry_msgs/msg/Twist"}),
        run=run,
    )


def run(run):
    from geometry_msgs.msg import Twist
    from sensor_msgs.msg import Joy

    ros = run.ros2(RosNode(package="joy_teleop", executable="joy_teleop", workspace=["src"],
                           parameters=[dict(flat(DRIVE, "drive"))]))
    stick = {"left": False, "right": False, "pushed": False}

    def record():
        run.recorder.signal(run.kernel.now_s, "held", stick["left"] and stick["right"])
        run.recorder.signal(run.kernel.now_s, "pushed", stick["pushed"])

    def joystick():
        sender = ros.node("joy").publisher("/joy", Joy)
        while True:
            buttons = [0] * 8
            for side, number in BUTTONS.items():
                buttons[number] = int(stick[side])
            sender.publish(Joy(axes=[0.0, 1.0 if stick["pushed"] else 0.0], buttons=buttons))
            run.kernel.sleep(0.05)

    def base():
        commands = ros.node("base").subscribe("/cmd_vel", Twist)
        run.recorder.signal(0.0, "speed", 0.0)
        while True:
            message = commands.wait(60.0)
            if message is not None:
                run.recorder.signal(run.kernel.now_s, "speed", message.linear.x)

    def person():
        record()
        run.kernel.sleep(1.0)
        for action in run.actions():
            verb, _, what = action.command.partition(" ")
            stick["pushed" if verb == "push" else what] = (what if verb == "push" else verb) in ("stick", "hold")
            record()
            run.kernel.sleep(action.parameters["for_s"])
        run.kernel.stop("the person has left")

    for each in (joystick, base, person):
        run.kernel.spawn(each.__name__, each)
    return Outcome(run.go(limit_s=120.0))
