"""What of the models corresponds to what in a run: the robot's agent as an oracle, and the person's as one who decides.

Both go by messages and by what can be seen from outside, never by the robot's variables.
"""

from __future__ import annotations

from carebot.orders import ENDING, FULL, UNKNOWN

from pytest_hricdv.testbench import ActionMapping, InteractiveAgent, ModelOracle, PerceptMapping

AT_ONCE_S = (0.0, 0.3)
"""The robot's own pace: a period of its loop, and a bit."""

DRIVES_S = (0.0, 330.0)
"""A drive, or what the robot gives up after: 60 s and twice what the longest way takes (chosen, as its own limit)."""

GRIPS_S = (0.0, 5.0)
"""The gripper has 4 s."""

GIVEN_UP = "on(refused) & " + " & ".join(f'refused.reason != "{reason}"' for reason in (UNKNOWN, FULL, ENDING))

KEPT_FROM_CHARGER = 'on(state) & state == "Ready" & previously(state == "Recharge") & !on(docked) & !on(accepted)'

ORACLE = ModelOracle(
    agent="robot",
    percepts=(PerceptMapping("order(Kind)", "on(order)", source="person"),),
    actions=(
        ActionMapping("accept(Order)", "on(accepted)", within_s=AT_ONCE_S),
        ActionMapping("refuse(Order)", "on(refused)", within_s=AT_ONCE_S),
        ActionMapping("enter(Name)", "on(state)", within_s=DRIVES_S),
        ActionMapping("food(Held)", "on(food)", within_s=GRIPS_S),
        ActionMapping("complete(Order)", "on(completed)", within_s=DRIVES_S),
        ActionMapping("report_idle", "on(idle)", within_s=AT_ONCE_S),
        ActionMapping("dock", "on(docked)", within_s=DRIVES_S),
    ),
    # How long drives and grips take is seen, and not modelled; when it is idle is its specification.
    limits={"travel_time": 0.001, "detour_time": 0.001, "grip_time": 0.001, "idle_after": 30.0},
    # It knows nobody who stays in the way, and no battery.
    until=f"{GIVEN_UP} | {KEPT_FROM_CHARGER} | on(state) & battery < 0.2",
)

ONLINE = InteractiveAgent(
    agent="person",
    percepts=(
        PerceptMapping("refused(Order)", f'on(refused) & refused.reason == "{UNKNOWN}"', source="robot"),
        PerceptMapping("given_up(Order)", GIVEN_UP, source="robot"),
        PerceptMapping("idle", "on(idle)", source="robot"),
        PerceptMapping("held_up", 'fall(acts) & state != "Ready" & state != "Off"', source="robot"),
    ),
)
