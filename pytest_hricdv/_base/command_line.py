"""The parser of commands: a misspelt command or option suggests the right one."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator
from difflib import get_close_matches
from typing import NoReturn

_CHOICE = re.compile(r"invalid choice: '([^']*)'")
_UNKNOWN = re.compile(r"unrecognized arguments: (-[^ =]*)")


class CommandParser(argparse.ArgumentParser):
    """A parser whose descriptions keep their lines; so are those of its subcommands."""

    def __init__(self, *arguments: object, **options: object) -> None:
        options.setdefault("formatter_class", argparse.RawDescriptionHelpFormatter)
        super().__init__(*arguments, **options)  # type: ignore[arg-type]

    def error(self, message: str) -> NoReturn:
        """Exit with status 2, the usage, and the nearest known name."""
        asked = _CHOICE.search(message) or _UNKNOWN.search(message)
        near = get_close_matches(asked[1], [*self._list_names()]) if asked else []
        if not (near and asked):
            super().error(message)
        # Two letters may be swapped, and the first one is seldom wrong.
        best = max(near, key=lambda name: (sorted(name) == sorted(asked[1]), name[0] == asked[1][0]))
        what = f"no {asked[1]!r} here" if _CHOICE.search(message) else message
        super().error(f"{what}; did you mean {best}?")

    def _list_names(self) -> Iterator[str]:
        """Commands and options, also those of subcommands."""
        for action in self._actions:
            yield from action.option_strings
            if isinstance(action, argparse._SubParsersAction):
                for name, parser in action.choices.items():
                    yield name
                    yield from parser._list_names()
