"""What keeps code from being imported and run as it is: missing modules, hardware, terminals, effects outside."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator, Sequence
from importlib.machinery import PathFinder

from pytest_hricdv.extra.draft.found.findings import Place, Problem
from pytest_hricdv.extra.draft.reading.sources import Module, Sources, dotted_name, imported_name
from pytest_hricdv.extra.draft.reading.value_flow import ValueFlow

HARDWARE = (
    "RPi", "gpiozero", "pigpio", "smbus", "smbus2", "spidev", "serial", "board", "busio", "digitalio", "adafruit_motor",
    "picamera", "picamera2", "pyrealsense2", "can", "pymodbus", "dynamixel_sdk", "rtde_control", "rtde_receive", "urx",
    "usb", "hid", "machine", "pyfirmata", "odrive", "wiringpi", "lgpio", "Jetson", "evdev", "pyaudio", "sounddevice",
)  # fmt: skip
"""Packages that drive hardware, by their top-level names."""

OUTSIDE = ("socket", "requests", "urllib", "http", "subprocess", "paho", "websockets", "aiohttp", "zmq", "grpc", "pika",
           "multiprocessing", "ssl", "smtplib", "ftplib", "sqlite3")  # fmt: skip
"""Modules that reach what is outside of the process."""

_READS = ("input", "sys.stdin.read", "sys.stdin.readline", "sys.stdin", "getpass.getpass", "termios.tcgetattr")
_EFFECTS = (
    "open",
    "os.system",
    "os.remove",
    "os.makedirs",
    "os.mkdir",
    "shutil.rmtree",
    "os.kill",
    "sys.exit",
    "exit",
    "quit",
)
_WAITS = ("time.sleep", "asyncio.run", "rclpy.init", "rclpy.spin", "threading.Thread")
_HARMLESS = ("logging", "os.environ", "os.path", "pathlib", "typing", "dataclasses", "collections")


def problems(sources: Sources, flow: ValueFlow) -> tuple[Problem, ...]:
    """All of them, syntax errors first; one for each kind and subject."""
    effects = [*sources.problems, *_missing(sources)]
    for module in sources.modules:
        effects += _at_import(module)
        if module.name in sys.stdlib_module_names:
            text = f"`{module.file}` has the name of a module of Python's own, and hides it from all others; rename it"
            effects.append(Problem("import", text, module.place(module.tree)))
    effects += _inside(flow)
    unique = {(problem.kind, problem.text): problem for problem in reversed(effects)}
    return tuple(reversed(unique.values()))


def _missing(sources: Sources) -> Iterator[Problem]:
    seen: set[str] = set()
    for dotted, place in sources.outside:
        top = dotted.partition(".")[0]
        if top in seen or top in sys.stdlib_module_names or top == "":
            continue
        seen.add(top)
        is_there = PathFinder.find_spec(top, [str(sources.root), *sys.path]) is not None
        if top in HARDWARE:
            rest = "installed here, but drives hardware" if is_there else "not installed here"
            yield Problem("hardware", f"`{top}` is {rest}: the draft puts a stand-in in its place", place)
        elif not is_there:
            text = f"`{top}` is not installed here: the draft puts a stand-in in its place; better install it"
            yield Problem("missing module", text, place)


def _at_import(module: Module) -> Iterator[Problem]:
    for statement in _executed(module.tree.body):
        for node in ast.walk(statement):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
                break
            if isinstance(node, ast.Call):
                text = _effect(imported_name(module, node.func), node)
                if text:
                    yield Problem(
                        "side effect", f"importing the module {text}; move it into a function", module.place(node)
                    )


def _executed(body: Sequence[ast.stmt]) -> Iterator[ast.stmt]:
    """Statements that an import executes, without definitions and without what only a main program does."""
    for statement in body:
        if isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            continue
        if isinstance(statement, ast.If):
            if "__name__" not in ast.unparse(statement.test) and "TYPE_CHECKING" not in ast.unparse(statement.test):
                yield from _executed([*statement.body, *statement.orelse])
        elif isinstance(statement, ast.Try | ast.With | ast.For | ast.While):
            yield from _executed(statement.body)
        else:
            yield statement


def _effect(call: str, node: ast.Call) -> str:
    """What a call at the top of a module does outside; empty where it does nothing."""
    top = call.partition(".")[0]
    if call in _READS:
        return f"reads a terminal (`{call}`)"
    if call in _WAITS or (call.endswith((".start", ".spin", ".connect", ".loop_forever")) and "." in call):
        return f"starts or waits (`{call}`)"
    if call == "open" and not _writes(node):
        return "reads a file (`open`)"
    if call in _EFFECTS:
        return f"has an effect outside (`{call}`)"
    if top in HARDWARE:
        return f"touches hardware (`{call}`)"
    if top in OUTSIDE and not call.startswith(_HARMLESS):
        return f"reaches outside (`{call}`)"
    return ""


def _writes(node: ast.Call) -> bool:
    mode = node.args[1] if len(node.args) > 1 else next((k.value for k in node.keywords if k.arg == "mode"), None)
    return (
        isinstance(mode, ast.Constant)
        and isinstance(mode.value, str)
        and any(letter in mode.value for letter in "wax+")
    )


def _inside(flow: ValueFlow) -> Iterator[Problem]:
    """Terminals and effects within functions; the first place of each."""
    terminal: Place | None = None
    outside: dict[str, Place] = {}
    for module, scope, node in flow.nodes:
        if not isinstance(node, ast.Call | ast.Attribute) or scope is None:
            continue
        call = imported_name(module, node.func if isinstance(node, ast.Call) else node)
        if (call in _READS and (isinstance(node, ast.Call) or call == "sys.stdin")) and terminal is None:
            terminal = module.place(node)
        if isinstance(node, ast.Call):
            top = call.partition(".")[0]
            if (top in OUTSIDE and "." in call) or call in ("os.system",):
                outside.setdefault(top, module.place(node))
            elif dotted_name(node.func) == "open" and _writes(node):
                outside.setdefault("open", module.place(node))
    if terminal is not None:
        yield Problem("terminal", "reads a terminal: in the draft a person presses its keys (`run.terminal`)", terminal)
    for top, place in outside.items():
        yield Problem(
            "outside", f"reaches outside with `{top}`: a run with it need not repeat, and is not made here", place
        )
