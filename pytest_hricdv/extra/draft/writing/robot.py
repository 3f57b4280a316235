"""The node of a drafted run that calls the robot's code, and what this is handed."""

from __future__ import annotations

import json

from pytest_hricdv.extra.draft.found.findings import Channel, Message, Port
from pytest_hricdv.extra.draft.writing.calls import call_lines, call_needs
from pytest_hricdv.extra.draft.writing.devices import device_class
from pytest_hricdv.extra.draft.writing.drafted import Draft, Thing
from pytest_hricdv.extra.draft.writing.plain_classes import OWN_CLASSES
from pytest_hricdv.extra.draft.writing.ports import bus_kind
from pytest_hricdv.extra.draft.writing.source_text import import_lines, message_classes

TAKEN = ("run", "world", "person", "robot", "manner", "hits", "note", "look", "made", "make", "program", "calls")
"""Names of a run: where the code's own function has one of them, it is not imported under it."""

_STOPS = 'run.kernel.stop("the robot has ended its work")'
"""Where the robot may end before the person leaves, this ends a run; elsewhere it is a fault of the run."""


def robot_lines(draft: Draft) -> list[str]:
    """The function `robot` of a run."""
    entry = draft.entry
    if entry is None:
        return _without_entry(draft)
    lines = []
    looked_at = [message for message in draft.plain if message.form == "state"]
    is_early = not entry.is_made and bool(looked_at or draft.findings.calls)
    is_apart = entry.name in TAKEN or is_early
    needs = [] if is_apart else [(entry.module, entry.name)]
    needs += [("ports", device_class(port)) for port in draft.devices]
    roles = {port.role for port in draft.ports if not port.default}
    needs += [("ports", "Stream")] if roles & {"reader", "writer"} and _streams(draft) else []
    channels = draft.findings.channels
    is_said = any(channel.direction == "said" for channel in channels)
    needs += [("ports", "Outbox")] if roles & {"publish", "queue"} or is_said else []
    is_heard = any(p.role == "queue" and p.direction != "said" for p in draft.ports)
    needs += [("ports", "Inbox")] if is_heard or any(channel.direction == "heard" for channel in channels) else []
    needs += message_classes(message for message in draft.plain if message.form not in OWN_CLASSES)
    needs += [("ports", "look") for message in draft.plain if message.form == "state"]
    handed_on = [port for port in draft.ports if port.role in ("settings", "parameter") and _is_handed(port)]
    needs += [need for port in handed_on for need in port.needs]
    queues = [p for p in draft.ports if p.role == "queue" and p.direction != "said"]
    needs += message_classes(thing.message for port in queues for thing in _things_of(draft, port))
    needs += call_needs(draft)
    needs += [("ports", "Connection")] if any(channel.is_connection for channel in channels) else []
    needs += [("ports", "instead")] if any(channel.made for channel in channels) else []
    needs += [("ports", "Bus")] if bus_kind(draft) in ("async", "callback", "inboxes", "topics") else []
    imports = [line[4:] for line in import_lines(draft, needs)]
    making_name = f'import_module("{entry.module}").{entry.name}' if is_apart else entry.name
    making = f"make({', '.join(_handed(draft, port) for port in entry.ports if _is_handed(port))})"
    handed = ", ".join(_handed(draft, port) for port in entry.method_ports if _is_handed(port))
    called = f"made.{entry.method}({handed})" if entry.method else making
    stays = ("asyncio.sleep" if entry.is_async else "run.kernel.sleep") + "(LIMIT_S)"
    if entry.is_made and not entry.method:
        called = ("asyncio.sleep" if entry.is_async else "run.kernel.sleep") + "(LIMIT_S)  # it is called back"
    made = [*_variables(draft), *([f"made = {making}"] if entry.is_made else []), *_attributes(draft)]
    around = [*map(_look, looked_at), *call_lines(draft)]
    early = around if is_early else []  # importing the code may be what runs it
    made += [] if is_early else around
    body = [f"        {line}" for line in [*imports, "", *early, f"make: Any = {making_name}", *made]]
    last = [f"await {called}" if entry.is_async else called]
    if entry.is_step:
        last = ["while True:", f"    {last[0]}  # it has no loop of its own", "    run.kernel.sleep(STEP_S)"]
        last[2:] = ["    await asyncio.sleep(STEP_S)"] if entry.is_async else last[2:]
    if draft.findings.calls and not entry.is_step and "LIMIT_S" not in called:
        last.append(f"{'await ' if entry.is_async else ''}{stays}  # it is called back")
    if entry.is_async:
        lines = ["    async def program() -> None:", *body, *(f"        {line}" for line in last), ""]
        lines += ["    def robot() -> None:", "        asyncio.run(program())"]
    else:
        lines = ["    def robot() -> None:", *body, *(f"        {line}" for line in last)]
    lines += [] if not draft.tells_presence else ['        world.record("robot_works", False)']
    return [*lines, *(["        " + _STOPS] if "early" in draft.may_end else [])]


def _look(message: Message) -> str:
    """The line that lets somebody look at the state."""
    return f'run.kernel.spawn("looks at the state", partial(look, run, lambda: {message.channel}))  # {message.place}'


def _without_entry(draft: Draft) -> list[str]:
    """Where nothing is to be called at once: importing the code may be all that it does, or somebody calls it."""
    looked_at = [message for message in draft.plain if message.form == "state"]
    needs = [*call_needs(draft), *(("ports", "look") for _ in looked_at)]
    lines = [line[4:] for line in import_lines(draft, needs)]
    if draft.findings.script:
        return _script(draft, lines)
    if not draft.findings.calls:
        lines.append("# TODO: nothing was found to call: call what runs the robot.")
    lines += [*([""] if lines else []), *_variables(draft)]
    lines += [f'import_module("{name}")' for name in draft.findings.code]
    lines += [*map(_look, looked_at), *call_lines(draft)]
    lines += ["run.kernel.sleep(LIMIT_S)  # it is called back"] if draft.findings.calls else []
    return ["    def robot() -> None:", *(f"        {line}".rstrip() for line in lines)]


def _script(draft: Draft, imports: list[str]) -> list[str]:
    """A program without a function: it is executed, with the terminal of the test."""
    channels = [channel for channel in draft.findings.channels if channel.name in ("input", "print", "stdin")]
    kinds = message_classes(message for message in draft.plain if message.form not in OWN_CLASSES)
    ends = [("ports", "Inbox" if channel.direction == "heard" else "Outbox") for channel in channels]
    lines = [line[4:] for line in import_lines(draft, [*ends, *kinds, ("ports", "run_script")])] + ["", *imports]
    lines += [f"{c.name}_: Any = {_end(draft, c.name, c.direction)}  # {c.place}" for c in channels]
    says = 'lambda *parts, **_: print_(" ".join(map(str, parts)))'
    names = ", ".join(f'"{c.name}": {says if c.name == "print" else f"{c.name}_"}' for c in channels)
    lines += [_look(message) for message in draft.plain if message.form == "state"]
    lines.append(f'run_script("{draft.findings.script}", {{{names}}})')
    lines += ['world.record("robot_works", False)'] if draft.tells_presence else []
    lines += [_STOPS] if "early" in draft.may_end else []
    return ["    def robot() -> None:", *(f"        {line}".rstrip() for line in lines)]


def _variables(draft: Draft) -> list[str]:
    """Queues of the code's modules that are those of the test."""
    lines = _connections(draft)
    for channel in draft.findings.channels:
        if channel.variables and not channel.is_connection:
            lines.append(f"{channel.name}_: Any = {_end(draft, channel.name, channel.direction)}  # {channel.place}")
            end = f"{channel.name}_"
            if channel.name == "print":
                end = 'lambda *parts, **_: print_(" ".join(map(str, parts)))'
            for module, name in channel.variables:
                lines += [f"import_module({json.dumps(module)}).__dict__[{json.dumps(name)}] = {end}"]
    return lines


def _attributes(draft: Draft) -> list[str]:
    """Queues that the robot makes itself, likewise."""
    ends = {channel.attribute: channel.name for channel in draft.findings.channels if channel.is_connection}
    lines = [f"made.{attribute} = {name}_" for attribute, name in ends.items() if attribute]
    return lines + [
        f"made.{channel.attribute} = {_end(draft, channel.name, channel.direction)}  # {channel.place}"
        for channel in draft.findings.channels
        if channel.attribute and not channel.is_connection
    ]


def _connections(draft: Draft) -> list[str]:
    """Connections that the code gets from the test: what is received and what is sent by one has one name."""
    lines: list[str] = []
    by_name: dict[str, list[Channel]] = {}
    for channel in draft.findings.channels:
        if channel.is_connection:
            by_name.setdefault(channel.name, []).append(channel)
    for name, ends in by_name.items():
        sides = ", ".join(_named(draft, name, direction) for direction in ("heard", "said"))
        heard = [end for end in ends if end.direction == "heard"] or ends
        lines.append(f"{name}_: Any = Connection(run, {sides}, is_text={heard[0].is_text})  # {ends[0].place}")
        for module, variable in dict.fromkeys(pair for end in ends for pair in end.variables):
            lines.append(f"import_module({json.dumps(module)}).__dict__[{json.dumps(variable)}] = {name}_")
        makers = dict.fromkeys(end.made for end in ends if end.made)
        lines += [f"instead({', '.join(json.dumps(part) for part in maker.split(':'))}, {name}_)" for maker in makers]
    return lines


def _named(draft: Draft, channel: str, direction: str) -> str:
    """The messages that come or go by a connection, as a tuple."""
    names = [m.name for m in draft.plain if m.channel == channel and m.direction == direction]
    return f"({', '.join(names)}{',' if len(names) == 1 else ''})"


def _end(draft: Draft, name: str, direction: str) -> str:
    """The queue of the test for what comes or goes by a name."""
    if direction == "heard":
        things = [thing.message.name for thing in draft.things if thing.message.channel in ("", name)]
        return f"Inbox({', '.join(['run', *things])})"
    kinds = [
        m.name for m in draft.plain if m.channel in ("", name) and m.direction != "heard" and m.form not in OWN_CLASSES
    ]
    return f"Outbox({', '.join(['run', *kinds])})"


def _is_handed(port: Port) -> bool:
    return not port.default


def _handed(draft: Draft, port: Port) -> str:
    """What the code gets for a port."""
    name = f"{port.name}=" if port.keyword else ""
    if port.role == "bus":
        return name + ('run.bus.port("robot")' if bus_kind(draft) == "own" else "Bus(run)")
    if port.role == "clock":
        return name + "run.kernel"
    if port.role == "publish":
        return name + _end(draft, port.name.strip("_"), "said")
    if port.role == "queue":
        return name + _end(draft, port.name.strip("_"), "said" if port.direction == "said" else "heard")
    if port.role in ("reader", "writer") and _streams(draft):
        return name + f"Stream(run, {', '.join(_side(draft, port, side) for side in ('heard', 'said'))})"
    if port.role == "device":
        return name + f"{device_class(port)}(world)"
    if port in draft.parameters:
        number = f'run.test.run["{port.name}"]'
        return name + (f"round({number})" if port.annotation == "int" else number)
    return name + (port.made or "None")


def _streams(draft: Draft) -> bool:
    """Whether lines come or go."""
    return any(message.form == "line" for message in draft.plain)


def _side(draft: Draft, port: Port, side: str) -> str:
    """The messages that come or go by a stream."""
    names = [m.name for m in draft.plain if m.channel == port.name.strip("_") and m.direction == side]
    return f"({', '.join(names)}{',' if len(names) == 1 else ''})"


def _things_of(draft: Draft, port: Port) -> list[Thing]:
    """What comes through a queue."""
    return [thing for thing in draft.things if thing.message.channel in ("", port.name.strip("_"))]
