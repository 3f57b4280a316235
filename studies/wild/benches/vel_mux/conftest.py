from pathlib import Path

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Ros2, RosNode, Testbench, Uniform

HERE = Path(__file__).parent
WAYS = {"ahead": (0.3, 0.0), "left": (0.0, 0.3), "up": (0.0, 0.0), "down": (0.0, 0.0), "zero": (0.0, 0.0)}
SERVICES = {"emergency": "std_srvs/srv/Empty", **{name: f"crazyflie_interfaces/srv/{kind}" for name, kind in (
    ("takeoff", "Takeoff"), ("land", "Land"), ("go_to", "GoTo"), ("upload_trajectory", "UploadTrajectory"),
    ("start_trajectory", "StartTrajectory"), ("notify_setpoints_stop", "NotifySetpointsStop"))}}


def pytest_hricdv_testbench(config):
    sends = {"then_s": Uniform(0.15, 4.0, "s")}
    return Testbench(
        name="vel_mux",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(start=("one_flight", "two_flights"), groups={"manner": ("calm", "hasty", "idle", "leaves")}),
        concretization=Concretization(
            commands={**{f"push {way}": sends for way in WAYS}, "leave": {"then_s": Uniform(2.0, 4.0, "s")}}
        ),
        requirements=HERE / "requirements.toml",
        messages=(),
        signals={"down": bool, "sideways": float},
        code=("crazyflie_examples.vel_mux",),
        ros2=Ros2(
            topics={"/cmd_vel": "geometry_msgs/msg/Twist", "/cf231/cmd_hover": "crazyflie_interfaces/msg/Hover"},
            services={f"/cf231/{name}": SERVICES[name] for name in ("takeoff", "land")},
            interfaces=("src/crazyswarm2/crazyflie_interfaces",),
            packages=("crazyflie_py",),
        ),
        run=run,
    )


def run(run):
    from crazyflie_interfaces.msg import Hover
    from geometry_msgs.msg import Twist
    from rcl_interfaces.msg import ParameterValue

    server = run.ros2(RosNode(entry="crazyflie_examples.vel_mux:main", name="vel_mux",
                              parameters=[{"hover_height": 0.3}]))  # as its launch file has it

    def settings(request, response):
        response.values = [ParameterValue(type=8, double_array_value=[0.0] * 3),
                           ParameterValue(type=4, string_value="radio://0/80/2M/E7E7E7E7E7")]
        return response

    node = server.node("crazyflie_server")
    for prefix in ("/all", "/cf231"):
        for name, kind in SERVICES.items():
            node.serve(f"{prefix}/{name}", kind, lambda request, response: response)
    for name, kind in (("set", "Set"), ("list", "List"), ("describe", "Describe"), ("get", "Get")):
        answer = settings if name == "get" else lambda request, response: response
        node.serve(f"/crazyflie_server/{name}_parameters", f"rcl_interfaces/srv/{kind}Parameters", answer)

    def drone():
        setpoints = server.node("drone").subscribe("/cf231/cmd_hover", Hover)
        while True:
            message = setpoints.wait(60.0)
            if message is not None:
                run.recorder.signal(run.kernel.now_s, "sideways", abs(message.vx) + abs(message.vy))

    def person():
        stick = server.node("person").publisher("/cmd_vel", Twist)
        run.recorder.signal(0.0, "down", False)
        run.recorder.signal(0.0, "sideways", 0.0)
        run.kernel.sleep(1.0)
        for action in run.actions():
            verb, _, way = action.command.partition(" ")
            if verb == "push":
                message = Twist()
                message.linear.x, message.linear.y = WAYS[way]
                message.linear.z = {"up": 0.1, "down": -0.5}.get(way, 0.0)
                run.recorder.signal(run.kernel.now_s, "down", way == "down")
                stick.publish(message)
            run.kernel.sleep(action.parameters["then_s"])
        run.kernel.sleep(6.0)
        run.kernel.stop("the person has left")

    run.kernel.spawn("drone", drone)
    run.kernel.spawn("person", person)
    return Outcome(run.go(limit_s=200.0))
