"""The world of a draft: what sensors say, and the signals that it records."""

from __future__ import annotations

from pytest_hricdv.extra.draft.writing.drafted import Draft

_INITIAL = {"bool": "False", "float": "0.0", "str": '""'}

_WORLD = '''

class World:
    """The world of a run. Replace it with your simulator; TODO: what moves, and what do sensors say then?"""

    def __init__(self, kernel: Kernel, recorder: Recorder{bus}) -> None:
        self._kernel, self._recorder = kernel, recorder
{calls}        self.senses: dict[str, bool | float] = dict(SENSES)
        for name, value in (*INITIAL.items(), *SENSES.items()):
            self.record(name, value)

    def record(self, name: str, value: bool | float | str) -> None:
        """Record a signal."""
        self._recorder.signal(self._kernel.now_s, name, value)

{now}{told}    def sense(self, name: str, value: bool | float) -> None:
        """From now on a sensor says this."""
        self.senses[name] = value
        self.record(name, value)

    def sleep(self, duration_s: float) -> None:
        """Let simulated time pass."""
        self._kernel.sleep(duration_s)
'''

_NOW = '''    @property
    def now_s(self) -> float:
        """Simulated time."""
        return self._kernel.now_s

'''

_WAYS = """        self.ways: dict[str, float] = {}  # sensor -> the share of its ways that it goes
"""

_TOLD = '''    def told(self, **values: Any) -> None:
        """Record what a device was told, as far as it is of the kind of its signal."""
        for name, value in values.items():
            number = isinstance(value, bool | int | float)
            if SIGNALS[name] is str and (number or isinstance(value, str)):
                self.record(name, f"{value:.4g}" if isinstance(value, float) else str(value))
            elif SIGNALS[name] is bool and isinstance(value, bool):
                self.record(name, value)
            elif SIGNALS[name] is float and number and isfinite(value):
                self.record(name, float(value))

'''

_CALLED = '''    def called(self, name: str, message: Any) -> None:
        """Tell others that a device was called. The same call again and again, as each 0.1 s, is told once."""
        before, now_s = self._calls.get(name), self._kernel.now_s
        self._calls[name] = (message, now_s)
        if before is None or before[0] != message or not 0.0 < now_s - before[1] <= REPEATS_S:
            self._bus.port(name).publish(message)

'''


def world(draft: Draft) -> str:
    """The module of the world."""
    lines = [
        '"""The world: a signal for each field that the robot says, and for each sensor that it reads."""',
        "",
        "from __future__ import annotations",
        "",
        *(["from math import isfinite"] if draft.told else []),
        *(["from typing import Any", ""] if draft.told or draft.called else []),
        f"from pytest_hricdv.runtime import {'Bus, ' if draft.called else ''}Kernel, Recorder",
        *(["", "REPEATS_S = 1.0  # a call that comes again so soon is told once; TODO"] if draft.called else []),
        "",
        "# What the code reads at its ports, and what it reads first. TODO: what is right for your robot?",
        "SENSES: dict[str, bool | float] = {",
    ]
    lines += [f'    "{sensor.name}": {sensor.first},  # {sensor.operation.place}' for sensor in draft.sensors]
    lines += [
        "}",
        "",
        "# The fields that the robot says, and what devices are told, before there was any.",
        "INITIAL: dict[str, bool | float | str] = {",
    ]
    for signal in draft.signals:
        lines.append(f'    "{signal.name}": {_INITIAL[signal.kind]},  # {signal.place}')
    if draft.tells_presence:
        lines += ['    "person_is_there": True,', '    "robot_works": True,']
    for port in draft.devices:
        if any(operation.kind == "method" for operation in port.operations):
            lines.append(f'    "{port.name}_did": "",  # {port.place}')
    driven = [port for port, motions in draft.motions.items() if any(motion.is_pose for motion in motions)]
    lines += [f'    "{port}_{axis}": 0.0,' for port in driven for axis in ("x", "y")]
    lines += [f'    "{told.signal}": {_INITIAL[told.kind]},  # {told.operation.place}' for told in draft.told]
    lines += ["}", ""]
    lines.append("SIGNALS: dict[str, type[bool | float | str]] = {")
    lines.append("    name: type(value) for name, value in (*INITIAL.items(), *SENSES.items())")
    lines.append("}")
    return "\n".join(lines) + "\n" + _class(draft)


def _class(draft: Draft) -> str:
    """The class of the world, with what this robot's devices need."""
    text = _WORLD.replace("{told}", (_TOLD if draft.told else "") + (_CALLED if draft.called else ""))
    text = text.replace("{bus}", ", bus: Bus" if draft.called else "")
    calls = "        self._bus = bus\n        self._calls: dict[str, tuple[Any, float]] = {}\n"
    calls = calls if draft.called else ""
    text = text.replace("{now}", _NOW if draft.motions else "")
    return text.replace("{calls}", calls + (_WAYS if draft.motions else ""))
