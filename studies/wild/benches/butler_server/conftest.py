from pathlib import Path

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Ros2, RosNode, Testbench, Uniform

HERE = Path(__file__).parent
ACTIONS = {"/food_delivery": "FoodDelivery", "/navigate_to_location": "NavigateToLocation"}
SERVICES = {"/confirm_location": "Confirmation", "/cancel_order": "CancelOrder"}


def pytest_hricdv_testbench(config):
    pause = {"after_s": Uniform(0.2, 4.0, "s")}
    return Testbench(
        name="butler_server",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(
            start=("one_order", "two_orders", "overlaps"),
            groups={"tables": ("one_table", "both_tables"), "manner": ("polite", "leaves", "changes_mind")},
        ),
        concretization=Concretization(
            commands={**dict.fromkeys(("order one", "order both", "cancel all", "cancel one", "confirm"), pause),
                      "wait": {"after_s": Uniform(3.0, 9.0, "s")}, "wait_result": {}},
        ),
        requirements=HERE / "requirements.toml",
        messages=(),
        signals={"at_home": bool},
        code=("food_delivery_robot",),
        ros2=Ros2(
            actions={name: f"butler_bot/action/{kind}" for name, kind in ACTIONS.items()},
            services={name: f"butler_bot/srv/{kind}" for name, kind in SERVICES.items()},
            interfaces=("src/butler_ws/butler_bot",),
        ),
        run=run,
    )


def run(run):
    ros = run.ros2(RosNode(entry="food_delivery_robot:main"))
    run.recorder.signal(0.0, "at_home", True)

    def go(goal):
        run.recorder.signal(run.kernel.now_s, "at_home", False)
        if goal.wait(4.0):
            return goal.cancel(success=False) if not goal.is_over else None
        run.recorder.signal(run.kernel.now_s, "at_home", goal.request.location_name == "home_pose")
        goal.succeed(success=True)

    ros.node("navigation").serve_action("/navigate_to_location", "butler_bot/action/NavigateToLocation", go)

    def person():
        node = ros.node("person")
        orders = node.action("/food_delivery", "butler_bot/action/FoodDelivery")
        confirms = node.client("/confirm_location", "butler_bot/srv/Confirmation")
        cancels = node.client("/cancel_order", "butler_bot/srv/CancelOrder")
        order = None
        run.kernel.sleep(1.0)
        for action in run.actions():
            run.kernel.sleep(action.parameters.get("after_s", 0.0))
            verb, _, what = action.command.partition(" ")
            if verb == "order":
                tables = [1] if what == "one" else [1, 2]
                order = orders.send(5.0, table_numbers=tables, confirmation_timeout=10.0) or order
            elif verb == "confirm":
                confirms.call(5.0, location="here")
            elif verb == "cancel":
                cancels.call(5.0, table_number=0 if what == "all" else 1)
            elif verb == "wait_result" and order is not None:
                order.result(120.0)
        run.kernel.sleep(90.0)
        run.kernel.stop("the person has left")

    run.kernel.spawn("person", person)
    return Outcome(run.go(limit_s=400.0))
