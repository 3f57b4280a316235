"""The methods by name, and what `--hri-suite` selects."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from .bdi_random import BdiPseudorandom
from .by_hand import ByHand
from .error import GenerateError, nearest
from .files import Files
from .method import Method
from .pseudorandom import Pseudorandom
from .rl import ReinforcementLearning

#: The methods of the paper, in its order.
METHODS: Mapping[str, Method] = {
    method.name: method for method in (ByHand(), BdiPseudorandom(), ReinforcementLearning(), Pseudorandom())
}
ALL = "all"


def select(selection: str, root: Path) -> tuple[Method, ...]:
    """The methods of a selection such as `by-hand,rl`, `all` or `tests/recorded.txt`, in order, each once.

    Args:
        selection: names, `all`, or paths of files and folders of tests, with commas between them.
        root: the folder that paths are relative to.

    Raises:
        GenerateError: a name that is no method, and no file or folder either; or nothing selected.
    """
    chosen: dict[Method, None] = {}
    for name in filter(None, (part.strip() for part in selection.split(","))):
        if name == ALL:
            chosen.update(dict.fromkeys(METHODS.values()))
        elif name in METHODS:
            chosen[METHODS[name]] = None
        elif (root / name).exists():
            chosen[Files(root / name)] = None
        else:
            raise GenerateError(
                f"suite {name!r} is no method, and there is no file or folder of that name in {root}"
                f"{nearest(name, (*METHODS, ALL))}"
            )
    if not chosen:
        raise GenerateError(f"suite {selection!r} selects nothing{nearest('', (*METHODS, ALL))}")
    return tuple(chosen)
