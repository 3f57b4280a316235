"""What the use of a reading says of it: its kind, the numbers that it is compared with, and where it usually is."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.extra.draft.analysis import analyse
from pytest_hricdv.extra.draft.found.port import Operation

CODE = """
NEAR_M = 0.5


class Robot:
    def __init__(self, bus, device, clock):
        self.device, self.clock, self.goes = device, clock, bus.subscribe(Go)

    def run(self):
        while True:
            self.goes.wait(1.0)
            {lines}

    def other(self):
        return self.seen > 2.0


class Go:
    pass
"""


def reading(folder: Path, lines: str) -> Operation:
    """What is found of `device.read`."""
    (folder / "robot_code.py").write_text(CODE.format(lines=lines.replace("\n", "\n            ")), encoding="utf-8")
    entry = analyse("robot_code", folder).entry
    assert entry is not None
    port = next(port for port in entry.ports if port.name == "device")
    return next(operation for operation in port.operations if operation.name == "read")


@pytest.mark.parametrize(
    ("lines", "returns", "compared", "usual"),
    [
        ("if self.device.read() < NEAR_M: pass", "float", (0.5,), "high"),
        ("if self.device.read() > 60: pass", "float", (60.0,), "low"),
        ("while self.device.read() < 60: pass", "float", (60.0,), "low"),
        ("if not self.device.read() < 60: pass", "float", (60.0,), "low"),
        ("if 60 > self.device.read(): pass", "float", (60.0,), "high"),
        ("near = self.device.read()\nif near < NEAR_M: pass", "float", (0.5,), "high"),
        ("a = self.device.read(1)\nb = self.device.read(2)\nif min(a, b) < 40: pass", "float", (40.0,), "high"),
        ("if (near := self.device.read()) < NEAR_M: print(near)", "float", (0.5,), "high"),
        ("self.seen = self.device.read()", "float", (2.0,), ""),
        ("near = self.device.read()\nif near < NEAR_M or near > 9: pass", "float", (0.5, 9.0), ""),
        ("done = self.device.read()\nif not done: pass", "bool", (), ""),
        ("text = self.device.read()\nif not text: pass\nprint(text.upper())", "", (), ""),
        ("self.goes.put(self.device.read())", "", (), ""),
    ],
)
def test_what_a_use_says(lines: str, returns: str, compared: tuple[float, ...], usual: str, tmp_path: Path) -> None:
    found = reading(tmp_path, lines)
    assert (found.returns, found.compared, found.usual) == (returns, compared, usual)
