"""Guides who leave state to the next test: each says at the beginning of a run what it found."""

from __future__ import annotations

import pytest

from tests.plugin import project

_BEGIN = "    greetings, wishes = bus.subscribe(Greeting), bus.subscribe(Wish)\n"
_HEAD = "GLARE = 80.0\n"

WAYS = {
    "list of a module": ("SERVED = []\n", "    SERVED.append(1)\n", "len(SERVED)"),
    "attribute of a class": ("class Guide:\n    served = 0\n", "    Guide.served += 1\n", "Guide.served"),
    "cache": (
        "import functools, itertools\n@functools.lru_cache\ndef numbers():\n    return itertools.count()\n",
        "",
        "next(numbers())",
    ),
    "singleton": (
        "class Desk:\n    made = None\n    def __new__(cls):\n        if cls.made is None:\n"
        "            cls.made = super().__new__(cls)\n            cls.made.visits = 0\n        return cls.made\n",
        "    Desk().visits += 1\n",
        "Desk().visits",
    ),
    "import": ("import sys\n", "", "'colorsys' in sys.modules or (__import__('colorsys') and False)"),
    "variable of the environment": (
        "import os\n",
        "    os.environ['SERVED'] = os.environ.get('SERVED', '') + '1'\n",
        "len(os.environ['SERVED'])",
    ),
    "current folder": (
        "import os\nfrom pathlib import Path\nHERE = Path(__file__).parents[1]\n",
        "    here = Path.cwd()\n    os.chdir(HERE / 'models' if here == HERE else HERE)\n",
        "here == HERE",
    ),
    "default of a parameter": (
        "def served(visits=[]):\n    visits.append(1)\n    return len(visits)\n",
        "",
        "served()",
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
