import sys
from pathlib import Path
from unittest.mock import MagicMock

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Ros2, RosNode, Testbench, Uniform

HERE = Path(__file__).parent
STATES = ("works", "runs_ahead", "delays", "stops")
sys.modules.update(dict.fromkeys(("pyaudio", "pyudev", "sounddevice"), MagicMock()))  # of the emergency stop, a microphone


def pytest_hricdv_testbench(config):
    return Testbench(
        name="ada_watchdog",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(start=("one_meal", "two_meals"), groups={
            "trouble": ("ahead", "late", "silent")}),
        concretization=Concretization(commands={f"sensor {name}": {"for_s": Uniform(0.3, 4.0, "s")} for name in STATES}),
        requirements=HERE / "requirements.toml",
        messages=(),
        signals={"passes": bool, "sensor_works": bool},
        code=("ada_watchdog", "ada_feeding.watchdog.ft_sensor_condition"),
        ros2=Ros2(topics={"/ada_watchdog/watchdog": "diagnostic_msgs/msg/DiagnosticArray"}),
        run=run,
    )


def run(run):
    from diagnostic_msgs.msg import DiagnosticArray
    from geometry_msgs.msg import WrenchStamped

    # The emergency stop needs an older rclpy: it declares a parameter of a type without a value.
    parameters = ["src/ada_feeding/ada_feeding/config/ada_watchdog.yaml", {"use_estop": False}]
    ros = run.ros2(RosNode(entry="ada_watchdog:main", name="ada_watchdog", parameters=parameters))
    state = ["works"]

    def record(**signals):
        for name, value in signals.items():
            run.recorder.signal(run.kernel.now_s, name, value)

    def sensor():
        sender, message = ros.node("sensor").publisher("/ada_watchdog/ft_topic", WrenchStamped), WrenchStamped()
        from pytest_hricdv.runtime.virtual.clocks import EPOCH
        while True:
            run.kernel.sleep(0.02)
            now_s = EPOCH.timestamp() + run.kernel.now_s + {"delays": -2.0, "runs_ahead": 5.0}.get(state[0], 0.0)
            message.header.stamp.sec, message.header.stamp.nanosec = int(now_s), int(now_s % 1 * 1e9)
            for part in (message.wrench.force, message.wrench.torque):
                part.x = part.y = part.z = run.kernel.now_s % 0.7
            if state[0] != "stops":
                sender.publish(message)

    def web_page():
        statuses = ros.node("page").subscribe("/ada_watchdog/watchdog", DiagnosticArray)
        while True:
            message = statuses.wait(60.0)
            if message is not None:
                record(passes=all(each.level == b"\0" for each in message.status))

    def person():
        record(passes=False, sensor_works=True)
        run.kernel.sleep(1.0)
        for action in run.actions():
            state[0] = action.command.partition(" ")[2]
            record(sensor_works=state[0] == "works")
            run.kernel.sleep(action.parameters["for_s"])
        run.kernel.stop("the meal is over")

    for each in (sensor, web_page, person):
        run.kernel.spawn(each.__name__, each)
    return Outcome(run.go(limit_s=120.0))
