"""The world of a draft: what sensors say, and the signals that it records."""

from __future__ import annotations

from pytest_hricdv.extra.draft.drafted import Draft

_INITIAL = {"bool": "False", "float": "0.0", "str": '""'}

_WORLD = '''

class World:
    """The world of a run. Replace it with your simulator; TODO: what moves, and what do sensors say then?"""

    def __init__(self, kernel: Kernel, recorder: Recorder) -> None:
        self._kernel, self._recorder = kernel, recorder
        self.senses: dict[str, bool | float] = dict(SENSES)
        for name, value in (*INITIAL.items(), *SENSES.items()):
            self.record(name, value)

    def record(self, name: str, value: bool | float | str) -> None:
        """Record a signal."""
        self._recorder.signal(self._kernel.now_s, name, value)

    def sense(self, name: str, value: bool | float) -> None:
        """From now on a sensor says this."""
        self.senses[name] = value
        self.record(name, value)

    def sleep(self, duration_s: float) -> None:
        """Let simulated time pass."""
        self._kernel.sleep(duration_s)
'''


def world(draft: Draft) -> str:
    """The module of the world."""
    lines = [
        '"""The world: a signal for each field that the robot says, and for each sensor that it reads."""',
        "",
        "from __future__ import annotations",
        "",
        "from pytest_hricdv.runtime import Kernel, Recorder",
        "",
        "# What the code reads at its ports, and what it reads first. TODO: what is right for your robot?",
        "SENSES: dict[str, bool | float] = {",
    ]
    for sensor in draft.sensors:
        value = "False" if sensor.kind == "bool" else repr(round(sensor.low[1], 6))
        lines.append(f'    "{sensor.name}": {value},  # {sensor.operation.place}')
    lines += [
        "}",
        "",
        "# The fields that the robot says, before it has said any.",
        "INITIAL: dict[str, bool | float | str] = {",
    ]
    for signal in draft.signals:
        lines.append(f'    "{signal.name}": {_INITIAL[signal.kind]},  # {signal.place}')
    if draft.tells_presence:
        lines += ['    "person_is_there": True,', '    "robot_works": True,']
    for port in draft.devices:
        if any(operation.kind == "method" for operation in port.operations):
            lines.append(f'    "{port.name}_did": "",  # {port.place}')
    lines += ["}", ""]
    lines.append("SIGNALS: dict[str, type[bool | float | str]] = {")
    lines.append("    name: type(value) for name, value in (*INITIAL.items(), *SENSES.items())")
    lines.append("}")
    return "\n".join(lines) + "\n" + _WORLD
