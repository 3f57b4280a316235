from dataclasses import dataclass
from pathlib import Path

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Ros2, RosNode, Testbench, Uniform, VirtualTime

HERE = Path(__file__).parent
ACTIONS = {"/undock": "irobot_create_msgs/action/Undock", "/dock": "irobot_create_msgs/action/Dock",
           "/navigate_to_pose": "nav2_msgs/action/NavigateToPose"}


@dataclass(frozen=True)
class SaysSucceeded:
    """The program says that the robot has arrived."""


def pytest_hricdv_testbench(config):
    return Testbench(
        name="mail_delivery",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(start=("one_letter", "two_letters", "stuck_dock"),
                            groups={"way": ("blocked", "refused", "typo")}),
        concretization=Concretization(commands={"let undock_fail": {}, "let undock_refuse": {},
            **{f"type {text}": {"after_s": Uniform(12.0, 20.0, "s")} for text in ("place", "word", "exit")},
            **{f"let {what}": {"after_s": Uniform(6.0, 9.0, "s")} for what in ("abort", "refuse")}}),
        requirements=HERE / "requirements.toml",
        messages=(SaysSucceeded,),
        signals={"docked": bool, "arrived": bool},
        code=("turtlebot4_python_tutorials.mail_delivery", "turtlebot4_navigation"),
        ros2=Ros2(actions=ACTIONS, packages=("nav2_simple_commander",),
                  interfaces=("src/irobot_create_msgs", "src/navigation2/nav2_msgs", "src/geographic_info/geographic_msgs")),
        time=VirtualTime(allowed_endings=("early",)),
        run=run,
    )


def run(run):
    from geometry_msgs.msg import PoseWithCovarianceStamped
    from irobot_create_msgs.msg import DockStatus
    from rcl_interfaces.msg import Log

    ros = run.ros2(RosNode(entry="turtlebot4_python_tutorials.mail_delivery:main"))
    keyboard, lets, world = run.terminal(), ["pass"], ros.node("world")

    def record(name, value):
        run.recorder.signal(run.kernel.now_s, name, value)

    def undock(goal):
        goal.wait(2.0)
        record("docked", lets[0] == "undock_fail")
        (goal.abort if lets[0] == "undock_fail" else goal.succeed)(is_docked=lets[0] == "undock_fail")

    def go(goal):
        goal.wait(4.0)
        record("arrived", lets[0] == "pass")
        (goal.succeed if lets[0] == "pass" else goal.abort)()

    def state(request, response):
        response.current_state.label = "active"
        return response

    world.serve_action("/undock", ACTIONS["/undock"], undock, accept=lambda goal: lets[0] != "undock_refuse")
    world.serve_action("/navigate_to_pose", ACTIONS["/navigate_to_pose"], go, accept=lambda goal: lets[0] != "refuse")
    for name in ("amcl", "bt_navigator"):
        world.serve(f"/{name}/get_state", "lifecycle_msgs/srv/GetState", state)

    dock = world.publisher("/dock_status", DockStatus)

    def localization():
        pose = world.publisher("/amcl_pose", PoseWithCovarianceStamped, latched=True)
        told = world.subscribe("/initialpose", PoseWithCovarianceStamped)
        while told.wait(60.0) is not None:
            pose.publish(PoseWithCovarianceStamped())

    def log():
        lines = ros.node("log").subscribe("/rosout", Log)
        while True:
            line = lines.wait(60.0)
            if line is not None and line.msg == "Goal succeeded!":
                run.bus.port("log").publish(SaysSucceeded())

    def person():
        record("docked", True)
        record("arrived", False)
        dock.publish(DockStatus(is_docked=True))
        for action in run.actions():
            verb, _, what = action.command.partition(" ")
            run.kernel.sleep(action.parameters.get("after_s", 0.0))
            if verb == "let":
                lets[0] = what
            elif what == "place":
                record("arrived", False)
            if verb == "type":
                keyboard.type({"place": "1\n", "word": "kitchen\n", "exit": "5\n"}[what])
        run.kernel.stop("the person has left")

    for each in (localization, log, person):
        run.kernel.spawn(each.__name__, each)
    return Outcome(run.go(limit_s=300.0))
