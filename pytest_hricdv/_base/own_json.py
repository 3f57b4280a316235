"""JSON with Python's own encoder and decoder, even if the code under test has patched `json` in this process.

Projects replace `json.dumps` or `JSONEncoder.default` to write their own types, for the whole process. Results and
hashes must not depend on that. So all modules that write or read them call `dumps` and `loads` of this module, whose
classes are bound when the plugin is loaded.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from json import JSONDecodeError as JSONDecodeError
from json.decoder import JSONDecoder
from json.encoder import JSONEncoder
from typing import Any


class _Encoder(JSONEncoder):
    """Python's encoder with its original methods."""

    default = JSONEncoder.default
    encode = JSONEncoder.encode
    iterencode = JSONEncoder.iterencode


class _Decoder(JSONDecoder):
    """Python's decoder with its original methods."""

    decode = JSONDecoder.decode
    raw_decode = JSONDecoder.raw_decode


@lru_cache(maxsize=32)  # a few combinations of options: making an encoder takes longer than most texts
def _encoder(
    sort_keys: bool,
    ensure_ascii: bool,
    allow_nan: bool,
    indent: int | None,
    separators: tuple[str, str] | None,
    default: Callable[[Any], Any] | None,
) -> _Encoder:
    return _Encoder(
        sort_keys=sort_keys,
        ensure_ascii=ensure_ascii,
        allow_nan=allow_nan,
        indent=indent,
        separators=separators,
        default=default,
    )


def dumps(
    value: object,
    *,
    sort_keys: bool = False,
    ensure_ascii: bool = True,
    allow_nan: bool = True,
    indent: int | None = None,
    separators: tuple[str, str] | None = None,
    default: Callable[[Any], Any] | None = None,
) -> str:
    """Like `json.dumps`."""
    return _encoder(sort_keys, ensure_ascii, allow_nan, indent, separators, default).encode(value)


_DECODER = _Decoder()


def loads(text: str | bytes, *, parse_constant: Callable[[str], Any] | None = None) -> Any:
    """Like `json.loads`, of UTF-8."""
    decoder = _DECODER if parse_constant is None else _Decoder(parse_constant=parse_constant)
    return decoder.decode(text if isinstance(text, str) else text.decode("utf-8"))
