"""Guides who leave state to the next test: each says at the beginning of a run what it found."""

from __future__ import annotations

import pytest

from tests.plugin import project

_BEGIN = "    greetings, wishes = bus.subscribe(Greeting), bus.subscribe(Wish)\n"
_HEAD = "GLARE = 80.0\n"

WAYS = {
    "list of a module": ("SERVED = []\n", "    SERVED.append(1)\n", "len(SERVED)"),
    "cache": (
        "import functools, itertools\n@functools.lru_cache\ndef numbers():\n    return itertools.count()\n",
        "",
        "next(numbers())",
    ),
    "import": ("import sys\n", "", "'colorsys' in sys.modules or (__import__('colorsys') and False)"),
    "variable of the environment": (
        "import os\n",
        "    os.environ['SERVED'] = os.environ.get('SERVED', '') + '1'\n",
        "len(os.environ['SERVED'])",
    ),
}
"""What it is that stays -> lines of the module, of the function, and what is said."""


def leave(lamps: pytest.Pytester, way: str) -> None:
    """Let the guide leave state in this way."""
    module, function, said = WAYS[way]
    say(lamps, said, module=module, function=function)


def say(lamps: pytest.Pytester, said: str, *, module: str = "", function: str = "") -> None:
    """Let the guide say a number at the beginning of each run."""
    project.change(lamps.path, "lamps/guide.py", _HEAD, f"{module}{_HEAD}")
    project.change(
        lamps.path, "lamps/guide.py", _BEGIN, f"{_BEGIN}{function}    bus.publish(Switched(float({said})))\n"
    )
