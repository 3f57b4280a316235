"""The model of a draft: a person with plans for each thing that the robot hears, a robot with one for each state."""

from __future__ import annotations

from pytest_hricdv.extra.draft.reading.naming import word
from pytest_hricdv.extra.draft.surroundings.sensing import Sensor
from pytest_hricdv.extra.draft.writing.drafted import MANNERS, Draft, Thing

NEVER = "never"

UNTIL_QUIET = "wait_quiet"
"""The command of who waits until the robot says nothing more."""

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
    if meanwhile(draft):
        beliefs["meanwhile"] = (NOTHING, *(f"changes_{how}" for how in PASSES_S))
        beliefs["what changes"] = tuple(map(_changes, meanwhile(draft)))
    dialogs = tuple(f"dialog_{number}" for number, _ in enumerate(draft.dialogs, 1))
    if in_order(draft) or dialogs:
        beliefs["order"] = (*(ORDERS if in_order(draft) else ORDERS[:1]), *dialogs)
    if leaves(draft):
        beliefs["at the end"] = LEAVES
    if in_order(draft):
        beliefs["left out"] = ("nothing_left_out", *(f"without_{command}" for command in in_order(draft)))
    return beliefs or {"how long": STAYS}


LEAVES = ("leaves_when_quiet", "leaves_at_once")
"""Whether a person waits at the end until the robot has said nothing for a while: one that has accepted an order has
not carried it out yet."""


def leaves(draft: Draft) -> bool:
    """Whether a person can tell when the robot is done: it says something, in a time that costs little."""
    return bool(draft.things and draft.answers) and draft.ros is None  # a node's timers make each second dear


ORDERS = ("each_once", "all_in_order", "all_quickly")
"""What a person says in a round: each thing once, or all that there is to say, one after the other, also
without waiting for answers."""

PASSES_S = {"soon": (0.2, 2.0), "later": (2.0, 12.0)}
"""When a sensor says something else while the robot is at work, and for how long (chosen: what begins at once, and
what takes a while)."""

MOST_MEANWHILE = 6
"""Of more sensors a round would take too long (chosen)."""

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
    beliefs: list[str] = []
    for thing in draft.things:
        beliefs.append(f"{thing.name}_{NEVER}")
        beliefs += [which(thing, thing.kinds[0].name)] if len(thing.kinds) > 1 else []
    beliefs += [NOTHING, _changes(meanwhile(draft)[0])] if meanwhile(draft) else []
    beliefs += [ORDERS[0]] if in_order(draft) or draft.dialogs else []
    beliefs += ["nothing_left_out"] if in_order(draft) else []
    beliefs += [LEAVES[0]] if leaves(draft) else []
    return tuple(beliefs)


def meanwhile(draft: Draft) -> tuple[Sensor, ...]:
    """The sensors that say something else for a while, when the robot was told something."""
    return draft.sensors[:MOST_MEANWHILE] if draft.things else ()


NOTHING = "nothing_changes"
"""The belief that sensors say the same while the robot is at work."""


def _changes(sensor: Sensor) -> str:
    """The belief that this sensor says something else, where one does."""
    return f"{word(sensor.name)}_changes"


def _dialogs(draft: Draft) -> list[str]:
    """The plans of the dialogs that first runs have found."""
    if not draft.dialogs:
        return []
    tells_robot = {command: _told(thing).rstrip(".") for thing in draft.things for command, _ in thing.commands}
    lines = ["// Orders that led far into the code in the first runs. TODO: which are your people's?"]
    for number, dialog in enumerate(draft.dialogs, 1):
        steps = []
        for step in dialog:
            command, _, how = step.partition(" ")
            steps.append(f"{command}({how})" if how else command)
            steps += [tells_robot[command]] if command in tells_robot else []
        lines.append(f"@dialog_{number} +!round : dialog_{number} <- {'; '.join(steps)}.")
    return lines


def _meanwhile(draft: Draft) -> list[str]:
    """The plans by which a sensor says something else for a while."""
    sensors = meanwhile(draft)
    if not sensors:
        return []
    lines = ["// While the robot is at work, a sensor says something else for a while. TODO: when, and for how long?"]
    lines += [f"@changes_{how} +!meanwhile : changes_{how} <- !change({how})." for how in PASSES_S]
    lines.append(f"@{NOTHING} +!meanwhile.")
    plans = []
    for sensor in sensors:
        name, (one, other) = word(sensor.name), levels(sensor)
        is_it = "" if sensor is sensors[0] else f"{_changes(sensor)} & "
        for was, now in ((one, other), (other, one)):
            context = f"{is_it}{name}_{was}" if was == one else is_it.removesuffix(" & ")
            body = f"let_pass(How); set_{name}({now}); let_pass(How); set_{name}({was})"
            plan = f"@{name}_changes_to_{now} +!change(How)" + (f" : {context}" if context else "")
            plans.append((sensor is sensors[0], f"{plan} <- {body}."))
    return [*lines, *(plan for is_last, plan in sorted(plans, key=lambda pair: pair[0])), ""]


def which(thing: Thing, kind: str) -> str:
    """The belief that a message is of this kind."""
    return f"{thing.name}_is_{kind}"


SHORT, WHOLE = "short", "whole"
"""How a sensor is set that follows what its device is told: it does not go all the way any more, or does so again."""


def levels(sensor: Sensor) -> tuple[str, str]:
    """The words for what a sensor can say."""
    if sensor.motion is not None:
        return (SHORT, WHOLE)
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
    end = "; !leave" if leaves(draft) else ""
    lines += ["", f"@once  +!visit : one_round  <- !round{end}."]
    lines += [f"@again +!visit : two_rounds <- !round; !round{end}.", ""]
    if leaves(draft):
        lines += [f"@{LEAVES[1]} +!leave : {LEAVES[1]}.", f"@{LEAVES[0]} +!leave <- {UNTIL_QUIET}.", ""]
    if in_order(draft):
        waits = "!meanwhile; wait_answer" if meanwhile(draft) else "wait_answer"
        seen = "".join(f"!see_{word(sensor.name)}; " for sensor in draft.sensors)
        forwards = "; ".join(f"!then_{command}" for command in in_order(draft))
        quickly = "; ".join(f"!quickly_{command}" for command in in_order(draft))
        lines += [f"@all_in_order +!round : all_in_order <- {seen}{forwards}."]
        lines += [f"@all_quickly +!round : all_quickly <- {seen}{quickly}; {waits}."]
    if in_order(draft) or draft.dialogs:
        lines += [*_dialogs(draft), f"@each_once +!round <- {body}.", ""]
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
    lines += _meanwhile(draft)
    waits = "!meanwhile; wait_answer" if meanwhile(draft) else "wait_answer"
    for thing in draft.things:
        lines += [*_plans(thing, waits), ""]
    if in_order(draft):
        lines.append("// Each of all that there is to say, where it is not left out.")
    for thing in draft.things if in_order(draft) else ():
        for command in (command for command, kind in thing.commands if kind.is_usual):
            lines.append(f"@leaves_out_{command} +!quickly_{command} : without_{command}.")
            lines.append(f"@says_{command} +!quickly_{command} <- {command}(in_time); {_told(thing)}")
            lines.append(f"+!then_{command} : without_{command}.")
            lines.append(f"+!then_{command} <- !quickly_{command}; wait_answer.")
    return "\n".join(lines).rstrip() + "\n"


def _plans(thing: Thing, waits: str) -> list[str]:
    name, lines = thing.name, [f"// {thing.message.place}"]
    lines += [f"@{name}_{how} +!do_{name} : {name}_{how} <- !say_{name}({how}); {waits}." for how in MANNERS]
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
