"""The node of a drafted run that calls the robot's code, and what the code gets from it."""

from __future__ import annotations

from pytest_hricdv.extra.draft.code_model import Port
from pytest_hricdv.extra.draft.project.draft import Draft, Input, import_lines, message_imports
from pytest_hricdv.extra.draft.project.ports import bus_class, device_class

TAKEN = ("run", "world", "person", "robot", "manner", "hits", "note", "instance", "make", "program")
"""Names of a run: where the code's own function has one of them, it is not imported under it."""

_STOPS = 'run.kernel.stop("the robot has ended its work")'
"""Where the robot may end before the person leaves, this ends a run; elsewhere it is a fault of the run."""


def robot_lines(draft: Draft) -> list[str]:
    """The function `robot` of a run."""
    entry = draft.entry
    if entry is None:
        lines = ["# TODO: nothing was found to call: call what runs the robot."]
        lines += [f'import_module("{name}")' for name in draft.code.modules]
        return ["    def robot() -> None:", *(f"        {line}" for line in lines)]
    is_shadowed = entry.name in TAKEN
    imports = _imports(draft) + ([] if is_shadowed else [(entry.module, entry.name)])
    passed = ", ".join(_passed(draft, port) for port in entry.ports if not port.default)
    made = f"make({passed})"
    lines = [line[4:] for line in import_lines(draft, imports)]
    making = f'import_module("{entry.module}").{entry.name}' if is_shadowed else entry.name
    lines += ["", f"make: Any = {making}"]
    waits = ("asyncio.sleep" if entry.is_async else "run.kernel.sleep") + "(LIMIT_S)  # its bus calls it back"
    called = made
    if entry.is_class:
        lines.append(f"instance = {made}" if entry.method else f"_ = {made}")
        arguments = ", ".join(_passed(draft, port) for port in entry.method_ports if not port.default)
        called = f"instance.{entry.method}({arguments})" if entry.method else waits
    lines.append(f"await {called}" if entry.is_async else called)
    if entry.is_async:
        body = ["    async def program() -> None:", *(f"        {line}" if line else "" for line in lines), ""]
        body += ["    def robot() -> None:", "        asyncio.run(program())"]
    else:
        body = ["    def robot() -> None:", *(f"        {line}" if line else "" for line in lines)]
    body += [] if not draft.tells_presence else ['        world.record("robot_works", False)']
    return [*body, *(["        " + _STOPS] if "early" in draft.may_end else [])]


def _imports(draft: Draft) -> list[tuple[str, str]]:
    """Names of `ports.py` and of the code that the arguments need."""
    passed = [port for port in draft.ports if not port.default]
    imports = [("ports", device_class(port)) for port in draft.devices]
    published = [port for port in passed if port.role == "publish" or port.direction == "published"]
    received = [port for port in passed if port.role == "queue" and port.direction != "published"]
    imports += [("ports", "Outbox")] if published else []
    imports += [("ports", "Inbox")] if received else []
    imports += message_imports(thing.message for port in received for thing in _inputs_of(draft, port))
    imports += [("ports", "Bus")] if bus_class(draft) not in ("", "own") else []
    for port in passed:
        imports += port.imports if port.role in ("settings", "parameter") and port not in draft.parameters else ()
    return imports


def _passed(draft: Draft, port: Port) -> str:
    """What the code gets for a port."""
    name = f"{port.name}=" if port.is_keyword else ""
    if port.role == "bus":
        return name + ('run.bus.port("robot")' if bus_class(draft) == "own" else "Bus(run)")
    if port.role == "clock":
        is_called = any(operation.name == "__call__" for operation in port.operations)
        called = "run.kernel.sleep" if port.name == "sleep" else "lambda: run.kernel.now_s"
        return name + (called if is_called else "run.kernel")
    if port.role == "publish" or port.direction == "published":
        return name + "Outbox(run)"
    if port.role == "queue":
        messages = [thing.message.name for thing in _inputs_of(draft, port)]
        return name + f"Inbox({', '.join(['run', *messages])})"
    if port.role == "device":
        return name + f"{device_class(port)}(world)"
    if port in draft.parameters:
        number = f'run.test.run["{port.name}"]'
        return name + (f"round({number})" if port.annotation == "int" else number)
    return name + (port.neutral or "None")


def _inputs_of(draft: Draft, port: Port) -> list[Input]:
    """What comes through a queue."""
    return [thing for thing in draft.inputs if thing.message.channel in ("", port.name.strip("_"))]
