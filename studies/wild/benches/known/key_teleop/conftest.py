import sys
from pathlib import Path
from types import SimpleNamespace

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Ros2, RosNode, Testbench, Uniform

HERE = Path(__file__).parent
KEYS, typed = {"up": 259, "down": 258, "left": 260, "right": 261}, []
nothing = lambda *arguments: None
screen = SimpleNamespace(nodelay=nothing, clear=nothing, addstr=nothing, refresh=nothing, getmaxyx=lambda: (40, 80),
                         getch=lambda: typed.pop(0) if typed else -1)
sys.modules["curses"] = SimpleNamespace(wrapper=lambda function: function(screen), curs_set=nothing, flash=nothing,
                                        **{f"KEY_{name.upper()}": code for name, code in KEYS.items()})
DELAY_S, REPEAT_S = 0.5, 0.03  # after which a held key repeats, on a desktop of Ubuntu 22.04


def pytest_hricdv_testbench(config):
    held = {"for_s": Uniform(0.1, 2.5, "s")}
    return Testbench(
        name="key_teleop",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(start=("one_drive", "two_drives"), groups={"manner": ("straight", "turns", "taps")}),
        concretization=Concretization(commands={**{f"hold {name}": held for name in KEYS}, "tap up": {},
                                                "rest": {"for_s": Uniform(0.5, 2.0, "s")}}),
        requirements=HERE / "requirements.toml",
        messages=(),
        signals={"speed": float, "is_held": bool},
        code=("key_teleop.key_teleop",),
        ros2=Ros2(),
        run=run,
    )


def run(run):
    from geometry_msgs.msg import TwistStamped

    typed.clear()
    ros = run.ros2(RosNode(entry="key_teleop.key_teleop:main", name="key_teleop"))

    def record(**signals):
        for name, value in signals.items():
            run.recorder.signal(run.kernel.now_s, name, value)

    def base():
        commands = ros.node("base").subscribe("/key_vel", TwistStamped)
        while True:
            message = commands.wait(60.0)
            if message is not None:
                record(speed=abs(message.twist.linear.x) + abs(message.twist.angular.z))

    def person():
        record(speed=0.0, is_held=False)
        run.kernel.sleep(1.0)
        for action in run.actions():
            verb, _, key = action.command.partition(" ")
            end_s = run.kernel.now_s + action.parameters.get("for_s", 0.05)
            if verb != "rest":
                record(is_held=True)
                typed.append(KEYS[key])
                run.kernel.sleep(min(DELAY_S, end_s - run.kernel.now_s))
                while run.kernel.now_s < end_s - 0.001:
                    typed.append(KEYS[key])
                    run.kernel.sleep(min(REPEAT_S, end_s - run.kernel.now_s))
                record(is_held=False)
            else:
                run.kernel.sleep(action.parameters["for_s"])
        run.kernel.sleep(2.0)
        run.kernel.stop("the person has left")

    for each in (base, person):
        run.kernel.spawn(each.__name__, each)
    return Outcome(run.go(limit_s=120.0))
