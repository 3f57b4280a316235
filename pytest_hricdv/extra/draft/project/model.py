"""Writes the agents of a draft (`models/`): a person with plans for each message, a robot with one for each state."""

from __future__ import annotations

from pytest_hricdv.extra.draft.code.naming import word
from pytest_hricdv.extra.draft.project.draft import MANNERS, Draft, Sensor
from pytest_hricdv.extra.draft.project.inputs import Input

NEVER = "never"

UNTIL_QUIET = "wait_quiet"
"""The command to wait until the robot publishes nothing more."""

STAY = "stay long"
"""The command of a person who is only present, with a robot whose inputs are unknown."""

LEAVES = ("leaves_when_quiet", "leaves_at_once")
"""Beliefs on how a visit ends: with a wait until the robot has been quiet for a while, as it may accept an order and
carry it out later, or without."""

ORDERS = ("each_once", "all_in_order", "all_quickly")
"""Beliefs on the order of messages in a round: each once, or all in a row, with or without waiting."""

MAX_IN_ORDER = 12
"""Most messages in a row; a round of more would take too long."""


def mas2j(draft: Draft) -> str:
    """The multi-agent system."""
    robot_too = " robot;" if draft.inputs else ""
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
    """The beliefs with the number of rounds: a second one shows nothing more if the person is only present."""
    return ("one_round",) if draft.is_alone else ("one_round", "two_rounds")


def belief_groups(draft: Draft) -> dict[str, tuple[str, ...]]:
    """The other beliefs, by their groups."""
    beliefs: dict[str, tuple[str, ...]] = {}
    for thing in draft.inputs:
        beliefs[f"when {thing.name}"] = tuple(f"{thing.name}_{how}" for how in (*MANNERS, NEVER))
        if len(thing.variants) > 1:
            beliefs[f"which {thing.name}"] = tuple(_which(thing, variant.name) for variant in thing.variants)
    for sensor in draft.sensors:
        beliefs[sensor.name] = tuple(f"{word(sensor.name)}_{level}" for level in words(sensor))
    if in_order(draft):
        beliefs["order"] = ORDERS
    if leaves(draft):
        beliefs["at the end"] = LEAVES
    if in_order(draft):
        beliefs["left out"] = ("nothing_left_out", *(f"without_{command}" for command in in_order(draft)))
    return beliefs or {"how long": ("stays_long",)}


def leaves(draft: Draft) -> bool:
    """Whether a person can tell when the robot is done: it publishes something, in a time that costs little."""
    return (
        bool((draft.inputs or draft.sensors) and draft.answers) and draft.ros is None
    )  # a node's timers make each second dear


def in_order(draft: Draft) -> tuple[str, ...]:
    """All messages that a person can say, in the code's order; empty if there is only one, or too many for a round."""
    commands = [command for thing in draft.inputs for command, variant in thing.commands if variant.is_usual]
    return tuple(commands) if 2 <= len(commands) <= MAX_IN_ORDER else ()


def neutral_beliefs(draft: Draft) -> tuple[str, ...]:
    """The beliefs that mean what happens without them."""
    beliefs: list[str] = []
    for thing in draft.inputs:
        beliefs.append(f"{thing.name}_{NEVER}")
        beliefs += [_which(thing, thing.variants[0].name)] if len(thing.variants) > 1 else []
    beliefs += [ORDERS[0], "nothing_left_out"] if in_order(draft) else []
    beliefs += [LEAVES[0]] if leaves(draft) else []
    return tuple(beliefs)


def _which(thing: Input, variant: str) -> str:
    """The belief that a message is of this variant."""
    return f"{thing.name}_is_{variant}"


def words(sensor: Sensor) -> tuple[str, ...]:
    """The words for what a sensor can return."""
    return tuple(level for level, _ in sensor.levels)


def person(draft: Draft) -> str:
    """The person's agent."""
    lines = [
        "// What a person does. Each label (@again) is a plan to be covered; actions become commands of the test.",
        "// TODO: what do people do with this robot, and in which order? This draft says all that the robot receives.",
    ]
    steps = [f"!see_{word(sensor.name)}" for sensor in draft.sensors]
    steps += [f"!do_{thing.name}" for thing in draft.inputs]
    body = "; ".join(steps if draft.inputs else [*steps, "wait_answer"])
    end = "; !leave" if leaves(draft) else ""
    lines += ["", f"@once  +!visit : one_round  <- !round{end}."]
    lines += [f"@again +!visit : two_rounds <- !round; !round{end}."] if not draft.is_alone else []
    lines += [""]
    if leaves(draft):
        lines += [f"@{LEAVES[1]} +!leave : {LEAVES[1]}.", f"@{LEAVES[0]} +!leave <- {UNTIL_QUIET}.", ""]
    if in_order(draft):
        seen = "".join(f"!see_{word(sensor.name)}; " for sensor in draft.sensors)
        forwards = "; ".join(f"!then_{command}" for command in in_order(draft))
        quickly = "; ".join(f"!quickly_{command}" for command in in_order(draft))
        waits = "" if leaves(draft) else "; wait_answer"  # of who leaves out all, too
        lines += [f"@all_in_order +!round : all_in_order <- {seen}{forwards}{waits}."]
        lines += [
            f"@all_quickly +!round : all_quickly <- {seen}{quickly}; wait_answer.",
            f"@each_once +!round <- {body}.",
            "",
        ]
    elif steps:
        lines += [f"+!round <- {body}.", ""]
    else:
        lines += ["// TODO: nothing is known that reaches the code. What makes it act?"]
        lines += ["@stays_long +!round : stays_long <- stay(long).", "@stays +!round <- stay(long).", ""]
    for sensor in draft.sensors:
        name = word(sensor.name)
        lines.append(f"// {sensor.operation.location}")
        lines += [
            f"@{name}_is_{level} +!see_{name} : {name}_{level} <- set_{name}({level})." for level in words(sensor)
        ]
        lines += [f"@{name}_stays +!see_{name}.", ""]
    for thing in draft.inputs:
        lines += [*_plans(thing), ""]
    if in_order(draft):
        lines.append("// Each of all that there is to say, where it is not left out.")
    for thing in draft.inputs if in_order(draft) else ():
        for command in (command for command, variant in thing.commands if variant.is_usual):
            lines.append(f"@leaves_out_{command} +!quickly_{command} : without_{command}.")
            lines.append(f"@says_{command} +!quickly_{command} <- {command}(in_time); {_tell_robot(thing)}")
            lines.append(f"+!then_{command} : without_{command}.")
            lines.append(f"+!then_{command} <- !quickly_{command}; wait_answer.")
    return "\n".join(lines).rstrip() + "\n"


def _plans(thing: Input) -> list[str]:
    name, lines = thing.name, [f"// {thing.message.location}"]
    lines += [f"@{name}_{how} +!do_{name} : {name}_{how} <- !say_{name}({how}); wait_answer." for how in MANNERS]
    lines.append(f"@{name}_never +!do_{name} <- wait_answer.")
    if len(thing.variants) == 1:
        action = thing.commands[0][0]
        return [*lines, f"@{name}_says +!say_{name}(How) <- {action}(How); {_tell_robot(thing)}"]
    first, *others = thing.variants
    for variant in (*others, first):  # the one without a context comes last
        context = "" if variant is first else f" : {_which(thing, variant.name)}"
        plan = f"@{_which(thing, variant.name)} +!say_{name}(How){context} <- {name}_{variant.name}(How); "
        lines.append(plan + _tell_robot(thing))
    return lines


def _tell_robot(thing: Input) -> str:
    return f".send(robot, achieve, heard_{thing.name})."


def robot(draft: Draft) -> str:
    """The robot's agent: a plan for each state, through which it goes when it receives something."""
    lines = [
        "// What the robot's code should do: a plan for each state, and one for each message that it receives.",
        "",
    ]
    machine = draft.machine
    if machine is not None:
        lines.append("// TODO: through which states does it go for which message? This draft goes through all of them.")
    tour = "; ".join(dict.fromkeys(f"!{_state_goal(state)}" for state in draft.states)) or "answer"
    lines += [f"@hears_{thing.name} +!heard_{thing.name} <- {tour}." for thing in draft.inputs]
    if machine is not None:
        lines.append("")
    goals = {_state_goal(state.name): state for state in machine.states} if machine is not None else {}
    for goal, state in goals.items():
        lines.append(f"@{goal} +!{goal} <- enter({word(state.name)}).  // {state.location}")
    return "\n".join(lines) + "\n"


def _state_goal(state: str) -> str:
    """The goal of the robot's agent to be in a state."""
    return f"be_{word(state)}"
