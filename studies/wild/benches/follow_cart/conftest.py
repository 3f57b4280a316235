from pathlib import Path

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Ros2, RosNode, Testbench, Uniform

HERE = Path(__file__).parent
PLACES = {"far": (2.5, 320.0), "near": (0.7, 320.0), "middle": (1.2, 320.0), "aside": (1.2, 520.0)}


def pytest_hricdv_testbench(config):
    time = {"for_s": Uniform(1.0, 6.0, "s")}
    return Testbench(
        name="follow_cart",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(
            start=("one_walk", "two_walks"),
            groups={"way": ("walks_far", "stays_near", "keeps_off", "goes_aside"), "end": ("covers_lens", "walks_off")},
        ),
        concretization=Concretization(
            commands={**{f"walk {place}": time for place in PLACES}, "cover_lens": time, "hide": time}
        ),
        requirements=HERE / "requirements.toml",
        messages=(),
        signals={"speed": float, "turn": float, "near": bool, "far": bool, "straight": bool, "offset": float},
        code=("follow_cart.pedestrian_follower",),
        ros2=Ros2(topics={"/convoy/detection": "std_msgs/msg/Float64MultiArray"}),
        run=run,
    )


def run(run):
    from geometry_msgs.msg import Twist
    from std_msgs.msg import Float64MultiArray

    ros = run.ros2(RosNode(entry="follow_cart.pedestrian_follower:main"))
    seen = [None]  # distance (m) and column of the person in the picture; None: the detector publishes nothing

    def record(**signals):
        for name, value in signals.items():
            run.recorder.signal(run.kernel.now_s, name, value)

    def camera():  # as pedestrian_detector does: a message for each picture in which there is a person
        sender = ros.node("detector").publisher("/convoy/detection", Float64MultiArray)
        while True:
            if seen[0] is not None:
                sender.publish(Float64MultiArray(data=[seen[0][1], 240.0, seen[0][0]]))
            run.kernel.sleep(0.1)

    def base():
        commands = ros.node("base").subscribe("/convoy/cmd_vel", Twist)
        while True:
            message = commands.wait(60.0)
            if message is not None:
                record(speed=message.linear.x, turn=message.angular.z)

    def person():
        record(speed=0.0, turn=0.0, near=False, far=False, straight=False, offset=0.0)
        for action in run.actions():
            place = action.command.partition(" ")[2]
            seen[0] = PLACES.get(place)
            record(near=place == "near", far=place == "far", straight=place in ("far", "near", "middle"))
            record(offset=seen[0][1] - 320.0 if seen[0] else 0.0)
            run.kernel.sleep(action.parameters["for_s"])
        run.kernel.stop("the person has left")

    for each in (camera, base, person):
        run.kernel.spawn(each.__name__, each)
    return Outcome(run.go(limit_s=120.0))
