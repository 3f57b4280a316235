"""The model of a draft: a person with plans for each thing that the robot hears, a robot with one for each state."""

from __future__ import annotations

from pytest_hricdv.extra.draft.drafted import MANNERS, Draft, Sensor, Thing
from pytest_hricdv.extra.draft.naming import word

NEVER = "never"

STAYS = ("stays_briefly", "stays_long")
"""How long a person stays with a robot of which nobody knows what it hears."""

STAY_S = {"briefly": (0.5, 5.0), "long": (20.0, 60.0)}
"""So long (chosen): a robot that acts of itself may say something at each instant, so that no answer ends a visit."""


def mas2j(draft: Draft) -> str:
    """The multi-agent system."""
    robot_too = " robot;" if draft.things else ""
    return f"MAS {draft.robot} {{ agents: meta; {draft.person};{robot_too} }}\n"


def meta(draft: Draft) -> str:
    """The steering agent."""
    return (
        "// The steering agent: hands the chosen beliefs to the person.\n"
        "// lint: percepts chosen\n"
        "!steer.\n"
        f"+!steer <- for (chosen(B)) {{ .send({draft.person}, tell, B) }}; .send({draft.person}, achieve, visit).\n"
    )


def start_beliefs(draft: Draft) -> tuple[str, ...]:
    """The beliefs that begin a run."""
    return ("one_round", "two_rounds")


def groups(draft: Draft) -> dict[str, tuple[str, ...]]:
    """The other beliefs, by their groups."""
    beliefs: dict[str, tuple[str, ...]] = {}
    for thing in draft.things:
        beliefs[f"when {thing.name}"] = tuple(f"{thing.name}_{how}" for how in (*MANNERS, NEVER))
        if len(thing.kinds) > 1:
            beliefs[f"which {thing.name}"] = tuple(which(thing, kind.name) for kind in thing.kinds)
    for sensor in draft.sensors:
        beliefs[f"{sensor.name}"] = tuple(f"{word(sensor.name)}_{level}" for level in levels(sensor))
    if in_order(draft):
        beliefs["order"] = ORDERS
        beliefs["left out"] = ("nothing_left_out", *(f"without_{command}" for command in in_order(draft)))
    return beliefs or {"how long": STAYS}


ORDERS = ("each_once", "all_in_order", "all_quickly")
"""What a person says in a round: each thing once, or all that there is to say, one after the other, also
without waiting for answers."""

MOST_IN_ORDER = 12
"""A round of more would take too long (chosen)."""


def in_order(draft: Draft) -> tuple[str, ...]:
    """All that a person can say, in the order of the code; empty where that is one thing, or too much for a round."""
    commands = [command for thing in draft.things for command, kind in thing.commands if kind.is_usual]
    return tuple(commands) if 2 <= len(commands) <= MOST_IN_ORDER else ()


def neutral_beliefs(draft: Draft) -> tuple[str, ...]:
    """The beliefs that mean what happens without them."""
    if draft.is_alone:
        return STAYS[:1]
    return tuple(
        belief
        for thing in draft.things
        for belief in (f"{thing.name}_{NEVER}", *((which(thing, thing.kinds[0].name),) if len(thing.kinds) > 1 else ()))
    ) + ((ORDERS[0], "nothing_left_out") if in_order(draft) else ())


def which(thing: Thing, kind: str) -> str:
    """The belief that a message is of this kind."""
    return f"{thing.name}_is_{kind}"


def levels(sensor: Sensor) -> tuple[str, str]:
    """The words for what a sensor can say."""
    return ("yes", "no") if sensor.kind == "bool" else ("low", "high")


def person(draft: Draft) -> str:
    """The person's agent."""
    lines = [
        "// What a person does. Each label (@again) is a plan to be covered; actions become commands of the test.",
        "// TODO: what do people do with this robot, and in which order? This draft says all that the robot can hear.",
    ]
    steps = [
        *(f"!see_{word(sensor.name)}" for sensor in draft.sensors),
        *(f"!do_{thing.name}" for thing in draft.things),
    ]
    body = "; ".join(steps if draft.things else [*steps, "wait_answer"])
    lines += ["", "@once  +!visit : one_round  <- !round.", "@again +!visit : two_rounds <- !round; !round.", ""]
    if in_order(draft):
        seen = "".join(f"!see_{word(sensor.name)}; " for sensor in draft.sensors)
        forwards = "; ".join(f"!then_{command}" for command in in_order(draft))
        quickly = "; ".join(f"!quickly_{command}" for command in in_order(draft))
        lines += [f"@all_in_order +!round : all_in_order <- {seen}{forwards}."]
        lines += [f"@all_quickly +!round : all_quickly <- {seen}{quickly}; wait_answer."]
        lines += [f"@each_once +!round <- {body}.", ""]
    elif steps:
        lines += [f"+!round <- {body}.", ""]
    else:
        lines += ["// TODO: nothing was found that the robot hears or reads. What makes it act?"]
        lines += ["@stays_long +!round : stays_long <- stay(long).", "@stays_briefly +!round <- stay(briefly).", ""]
    for sensor in draft.sensors:
        name = word(sensor.name)
        lines.append(f"// {sensor.operation.place}")
        lines += [
            f"@{name}_is_{level} +!see_{name} : {name}_{level} <- set_{name}({level})." for level in levels(sensor)
        ]
        lines += [f"@{name}_stays +!see_{name}.", ""]
    for thing in draft.things:
        lines += [*_plans(thing), ""]
    if in_order(draft):
        lines.append("// Each of all that there is to say, where it is not left out.")
    for thing in draft.things if in_order(draft) else ():
        for command in (command for command, kind in thing.commands if kind.is_usual):
            lines.append(f"@leaves_out_{command} +!quickly_{command} : without_{command}.")
            lines.append(f"@says_{command} +!quickly_{command} <- {command}(in_time); {_told(thing)}")
            lines.append(f"+!then_{command} : without_{command}.")
            lines.append(f"+!then_{command} <- !quickly_{command}; wait_answer.")
    return "\n".join(lines).rstrip() + "\n"


def _plans(thing: Thing) -> list[str]:
    name, lines = thing.name, [f"// {thing.message.place}"]
    lines += [f"@{name}_{how} +!do_{name} : {name}_{how} <- !say_{name}({how}); wait_answer." for how in MANNERS]
    lines.append(f"@{name}_never +!do_{name} <- wait_answer.")
    if len(thing.kinds) > 1:
        first = thing.kinds[0].name
        for kind in thing.kinds:
            context = "" if kind.name == first else f" : {which(thing, kind.name)}"
            plan = f"@{which(thing, kind.name)} +!say_{name}(How){context} <- {name}_{kind.name}(How); "
            lines.append(plan + _told(thing))
        lines = [*lines[: -len(thing.kinds)], *lines[-len(thing.kinds) + 1 :], lines[-len(thing.kinds)]]
    else:
        kind_name = thing.kinds[0].name
        action = f"{name}_{kind_name}".strip("_")
        lines.append(f"@{name}_says +!say_{name}(How) <- {action}(How); {_told(thing)}")
    return lines


def _told(thing: Thing) -> str:
    return f".send(robot, achieve, heard_{thing.name})."


def robot(draft: Draft) -> str:
    """The robot's agent: a plan for each state, through which it goes when it hears something."""
    lines = ["// What the robot's code should do: a plan for each state, and one for each thing that it can hear.", ""]
    states = draft.states
    if states:
        lines.append("// TODO: through which states does it go for what it hears? This draft goes through all of them.")
    tour = "; ".join(f"!{state_goal(state)}" for state in states) or "answer"
    lines += [f"@hears_{thing.name} +!heard_{thing.name} <- {tour}." for thing in draft.things]
    if states:
        lines.append("")
    machine = next((machine for machine in draft.findings.machines if machine.told), None)
    for state in machine.states if machine is not None else ():
        goal = state_goal(state.name)
        lines.append(f"@{goal} +!{goal} <- enter({word(state.name)}).  // {state.place}")
    return "\n".join(lines) + "\n"


def state_goal(state: str) -> str:
    """The goal of the robot's agent to be in a state."""
    return f"be_{word(state)}"
