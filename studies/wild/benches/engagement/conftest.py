import sys
from pathlib import Path
from types import SimpleNamespace

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Ros2, RosNode, Testbench, Uniform

HERE = Path(__file__).parent
STATUS, LEVEL = "/humans/persons/p1/engagement_status", "hri_msgs/msg/EngagementLevel"
LOOKS = {"at_robot": (1.5, (-0.5, -0.5, 0.5, 0.5)), "away": (1.5, (-0.5, 0.5, -0.5, 0.5)), "from_afar": (6.0, (-0.5, -0.5, 0.5, 0.5))}
people = {}
listener = SimpleNamespace(tracked_persons=people, set_reference_frame=lambda frame: None)
sys.modules["hri"] = SimpleNamespace(HRIListener=lambda *arguments: listener, Person=object)  # a binding of C++


def pytest_hricdv_testbench(config):
    commands = (*(f"look {how}" for how in LOOKS), "turn_around", "leave")
    return Testbench(
        name="engagement",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(start=("one_talk", "two_talks"), groups={"end": ("looks_off", "turns", "walks_off", "backs_off")}),
        concretization=Concretization(commands={name: {"for_s": Uniform(9.0, 25.0, "s")} for name in commands}),
        requirements=HERE / "requirements.toml",
        messages=(),
        signals={"engaged": bool, "mutual": bool, "visible": bool, "there": bool},
        code=("hri_engagement.engagement_node",),
        ros2=Ros2(topics={STATUS: LEVEL}, interfaces=("src/hri_msgs", "src/hri_actions_msgs")),
        run=run,
    )


def run(run):
    from geometry_msgs.msg import TransformStamped
    from lifecycle_msgs.msg import Transition

    people.clear()
    ros = run.ros2(RosNode(entry="hri_engagement.engagement_node:main", name="hri_engagement"))

    def record(**signals):
        for name, value in signals.items():
            run.recorder.signal(run.kernel.now_s, name, value)

    def interface():
        levels = ros.node("robot").subscribe(STATUS, LEVEL)
        while True:
            message = levels.wait(99.0)
            if message is not None:
                record(engaged=message.level == 3)

    def person():
        record(engaged=False, mutual=False, visible=False, there=False)
        change = ros.node("launch").client("/hri_engagement/change_state", "lifecycle_msgs/srv/ChangeState")
        for transition in (1, 3):  # configure, activate
            change.call(5.0, transition=Transition(id=transition))
        for action in run.actions():
            verb, _, how = action.command.partition(" ")
            face = None
            if verb == "look":
                face = SimpleNamespace(gaze_transform=TransformStamped())
                place = face.gaze_transform.transform
                place.translation.x, turn = LOOKS[how]
                place.rotation.x, place.rotation.y, place.rotation.z, place.rotation.w = turn
            if verb == "leave":
                people.clear()
            else:
                people.setdefault("p1", SimpleNamespace(id="p1", ns="/humans/persons/p1")).face = face
            record(mutual=how == "at_robot", visible=face is not None, there=verb != "leave")
            run.kernel.sleep(action.parameters["for_s"])
        run.kernel.stop("the person has gone")

    run.kernel.spawn("interface", interface)
    run.kernel.spawn("person", person)
    return Outcome(run.go(limit_s=300.0))
