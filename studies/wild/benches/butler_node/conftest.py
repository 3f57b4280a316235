from dataclasses import dataclass
from pathlib import Path

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Ros2, RosNode, Testbench, Uniform

HERE = Path(__file__).parent
TEXTS = {"table": "Order for Table 2", "words": "A tea, please", "blank": ""}


@dataclass(frozen=True)
class Received:
    """The robot says that it has an order."""


@dataclass(frozen=True)
class Delivered:
    """The robot says that it has delivered."""


@dataclass(frozen=True)
class Confirmed:
    """Somebody in the kitchen has confirmed: nobody ever does in these tests."""


def pytest_hricdv_testbench(config):
    pause = {"after_s": Uniform(0.2, 5.0, "s")}
    return Testbench(
        name="butler_node",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(
            start=("one_order", "two_orders", "at_once"), groups={"words": ("polite", "chatty", "silent")}
        ),
        concretization=Concretization(
            commands={**{f"order {what}": pause for what in TEXTS}, "wait": {"after_s": Uniform(9.0, 20.0, "s")}}
        ),
        requirements=HERE / "requirements.toml",
        messages=(Received, Delivered, Confirmed),
        signals={"is_table": bool},
        code=("restaurant_butler.butler_node",),
        ros2=Ros2(topics={"/order_topic": "std_msgs/msg/String"}),
        run=run,
    )


def run(run):
    from rcl_interfaces.msg import Log
    from std_msgs.msg import String

    ros = run.ros2(RosNode(package="restaurant_butler", executable="butler_node", workspace=["src"]))
    run.recorder.signal(0.0, "is_table", False)

    def log():
        lines, bus = ros.node("log").subscribe("/rosout", Log), run.bus.port("log")
        while True:
            line = lines.wait(60.0)
            if line is not None and line.msg.startswith("Received"):
                bus.publish(Received())
            elif line is not None and line.msg.startswith("Delivered"):
                bus.publish(Delivered())

    def person():
        sender = ros.node("person").publisher("/order_topic", String)
        run.kernel.sleep(1.0)
        for action in run.actions():
            run.kernel.sleep(action.parameters["after_s"])
            verb, _, what = action.command.partition(" ")
            if verb == "order":
                run.recorder.signal(run.kernel.now_s, "is_table", what == "table")
                sender.publish(String(data=TEXTS[what]))
        run.kernel.sleep(61.0)
        run.kernel.stop("the guests have left")

    for each in (log, person):
        run.kernel.spawn(each.__name__, each)
    return Outcome(run.go(limit_s=200.0))
