"""`lark_parser` makes a parser from a lark grammar, and caches it, since building its tables is slow.

The parsers of AgentSpeak (`bdi.language.parser`) and of requirements (`monitor.syntax_tree`) come from it. The cache is
in the user's cache folder. A cached parser is a pickle, so the cache is only used if no other user can write to this
folder. A file that is missing, damaged or from other versions is ignored and replaced.
"""

from __future__ import annotations

import contextlib
import os
import stat
import sys
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_hricdv._base.atomic_file import write_bytes
from pytest_hricdv._base.message import InputError

if TYPE_CHECKING:
    from lark import Lark

_DIGEST_BYTES = sha256().digest_size


class LarkError(InputError):
    """The installed `lark` is not a version that this package can use."""


def require_lark() -> None:
    """Check that the installed `lark` is recent enough.

    The old distribution lark-parser, which packages of ROS need, installs into the same folder.

    Raises:
        LarkError: it is too old.
    """
    import lark

    if not hasattr(getattr(lark, "Tree", None), "__class_getitem__"):  # new in 1.0, like the transformers' arguments
        place, version = getattr(lark, "__file__", None), getattr(lark, "__version__", "unknown")
        raise LarkError(
            f"{place}: lark of version {version}; expected 1.2 or later. An old lark-parser, as packages of ROS bring "
            "it, overwrites it: pip uninstall lark-parser, then pip install --force-reinstall 'lark>=1.2'"
        )


def lark_parser(grammar: Path, **options: Any) -> Lark:
    """The LALR parser of a grammar file.

    Args:
        grammar: the file, which imports no other.
        options: the options of `lark.Lark`. The postlexer must be a stateless instance of a class that can be pickled.

    Raises:
        LarkError: the installed lark is too old.
    """
    from lark import Lark

    require_lark()

    text = grammar.read_text(encoding="utf-8")
    file = _cache_file(grammar.stem, text, options)
    parser = None if file is None else _load(file)
    if parser is None:
        parser = Lark(text, parser="lalr", **options)
        if file is not None:
            _save(parser, file)
    return parser


def _cache_file(name: str, text: str, options: dict[str, Any]) -> Path | None:
    """The cache file of a parser, in a folder that is created; None if the folder is not safe to use."""
    import lark

    try:
        folder = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "pytest-hricdv"
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        if not _is_private(folder):
            return None
    except (OSError, RuntimeError):  # RuntimeError: there is no home folder
        return None
    described = {name: type(value) if name == "postlex" else value for name, value in sorted(options.items())}
    key = sha256(repr((text, described, lark.__version__, sys.version)).encode()).hexdigest()
    return folder / f"{name}-{key[:16]}.lark"


def _is_private(folder: Path) -> bool:
    """Whether the folder belongs to this user, and no other can write to it."""
    if sys.platform == "win32":
        return True  # The user's profile is private; the mode says nothing there.
    status = folder.stat()
    return status.st_uid == os.getuid() and not status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


def _load(file: Path) -> Lark | None:
    """The parser in a cache file; None if it is missing or cannot be used."""
    from lark import Lark

    try:
        content = file.read_bytes()
        digest, data = content[:_DIGEST_BYTES], content[_DIGEST_BYTES:]
        return Lark.load(BytesIO(data)) if digest == sha256(data).digest() else None
    except Exception:  # whatever is wrong with the cache, the parser can be built from the grammar
        return None


def _save(parser: Lark, file: Path) -> None:
    """Write a parser to its cache file, if possible."""
    buffer = BytesIO()
    parser.save(buffer)
    data = buffer.getvalue()
    with contextlib.suppress(OSError):
        write_bytes(file, sha256(data).digest() + data)
