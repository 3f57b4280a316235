"""Packages that nobody would write: odd names, texts, sizes and syntax, made of a seed."""

from __future__ import annotations

from pathlib import Path
from random import Random

TEXTS = (
    *(
        "don't know",
        'say "x"',
        "return",
        "class",
        "not",
        "true",
        "a\nb",
        "tab\t",
        "\\",
        "größe",
        "日本",
        "",
        " ",
        "a" * 300,
    ),
    *("{x}", "%s", "#", "'''", '"""', "None", "-1", "a.b", "x;y", "+!go", "~not", "[R1]", "lambda", "\u2028", "\r"),
)
NAMES = (
    *("größe_m", "Field", "Testbench", "Uniform", "Order", "state", "match", "type", "_x", "driver", "says", "HERE"),
    *("Device", "Say", "json", "Path", "person", "robot", "print", "名前", "Driver", "Model", "after_s", "what"),
    *("length", "dict", "str", "drafted_messages", "config", "mod", "count", "on", "always", "kind"),
)
TYPES = (
    "str",
    "int",
    "float",
    "bool",
    "list[float]",
    "Mode",
    "Missing",
    "dict",
    "tuple[int, ...]",
    "Later",
    "str | None",
)
FILES = ("robot.py", "my-robot.py", "class.py", "a\nb.py", "tests.py", "world.py", "json.py", "conftest.py")
FOLDERS = ("pkg", "my pkg", "pkg/sub", "größe")
HEAD = """from __future__ import annotations
import asyncio, json, queue, time
from dataclasses import dataclass, field
from enum import Enum
from typing import *
{imports}
class Mode(Enum):
    A = {first!r}
    B = {second!r}
"""
IMPORTS = ("", "import nowhere", "try:\n    import rospy\nexcept ImportError:\n    rospy = None", "import serial")
BASES = ("", "(NamedTuple)", "(TypedDict)", "(Enum)", "(Missing)", "(BaseModel)", "(Protocol)")
ODD = (
    "def f(x):\n" + "".join(f"    {'el' * (n > 0)}if x == 'v{n}':\n        return {n}\n" for n in range(2000)),
    "class A1(B1): pass\nclass B1(A1): pass\nclass C1(C1): pass",
    "x = " + "(" * 150 + "1" + ")" * 150,
    "def broken(:\n",
    "\n".join(f"@dataclass\nclass K{n}:\n    a: int" for n in range(70)),
    "x = " + " + ".join(["1"] * 3000),
    "def outer():\n    @dataclass\n    class Inner:\n        a: int\n"
    "    def inner(bus):\n        bus.publish(Inner(1))\n    return inner",
    "def rec(a):\n    b = rec(a)\n    return rec(b)\nz = z1 = z2 = rec(1)\nq = q",
)
PORTS = (
    "bus",
    "inbox: queue.Queue",
    "arm",
    "client",
    "on_done",
    "clock",
    "x: int",
    "dev: 'Missing | None' = None",
    "a=1",
)
METHODS = ("run", "go", "press", "tick", "_on", "match", "what")
PARAMETERS = ("", "msg", "a, b=1", "dt", "x: Mode")


def write_package(seed: int, folder: Path) -> str:
    """Write one, and return how it is asked for. Raises OSError where the file system has no such names."""
    random = Random(seed)
    names = [random.choice(NAMES) for _ in range(random.randint(1, 4))]
    parts = [HEAD.format(imports=random.choice(IMPORTS), first=random.choice(TEXTS), second=random.choice(TEXTS))]
    parts += [_class(random, name) for name in names]
    parts += [random.choice(ODD)] if random.random() < 0.6 else []
    parts += [_robot(random, names)]
    where, file = random.choice(FOLDERS), random.choice(FILES)
    package = folder / where
    package.mkdir(parents=True)
    if random.random() < 0.7:
        (package / "__init__.py").write_text("", encoding="utf-8")
    (package / file).write_text(
        "\n".join(parts), encoding=random.choice(("utf-8", "utf-8", "latin-1")), errors="replace"
    )
    if random.random() < 0.1:
        (package / "link").symlink_to(package)
    return random.choice((where, f"{where}/{file}", where.replace("/", "."), f"./{where}", f"{where}:Robot2"))


def _class(random: Random, name: str) -> str:
    decorator = random.choice(
        ("@dataclass", "@dataclass(frozen=True)", "@dataclass(kw_only=True)", "", "@attrs.define")
    )
    base = random.choice(BASES) if not decorator else ""
    fields = [f"    {random.choice(NAMES)}: {random.choice(TYPES)}{random.choice(('', ' = None'))}"
              for _ in range(random.randint(0, 6))]  # fmt: skip
    if base == "(Enum)":
        fields = [f"    M{number} = {random.choice(TEXTS)!r}" for number in range(random.randint(1, 5))]
    return f"{decorator}\nclass {name}{base}:\n" + ("\n".join(fields) or "    pass") + "\n"


def _robot(random: Random, names: list[str]) -> str:
    ports = sorted(
        {random.choice((*PORTS, f"s: {names[0]}")) for _ in range(random.randint(0, 4))}, key=lambda port: "=" in port
    )
    held = [port.partition(":")[0].partition("=")[0].strip() for port in ports]
    own = random.choice(names)
    lines = [f"    def __init__(self, {', '.join(ports)}):", *(f"        self.{name} = {name}" for name in held)]
    lines += [f"        self.state = {random.choice(TEXTS)!r}"]
    lines += [
        f"    def {random.choice(METHODS)}(self, {random.choice(PARAMETERS)}):",
        f"        self.state = {random.choice(TEXTS)!r}",
    ]
    for name in held:
        one, other = random.choice(TEXTS), random.choice(TEXTS)
        lines += [f"        m = self.{name}.get()", f"        if m[{one!r}] == {other!r}: self.{name}.publish({own}())",
                  f"        if isinstance(m, {own}) and m.{random.choice(NAMES)} == {other!r}:",
                  f"            self.{name}.put({own}({one!r}))",
                  f"        self.{name}.subscribe({one!r}, self.run)", f"        self.{name}.on_x = self.go",
                  f"        if self.{name}.read() > {random.choice((1, -1e300, 1e-300))}: pass"]  # fmt: skip
    return f"class {random.choice(('Robot', *names))}2:\n" + "\n".join(lines) + "\n"
