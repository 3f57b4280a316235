"""Plain records: the base class of everything in reports, journals and histories, and the types of their fields.

A record is a msgspec struct: frozen like a frozen dataclass, but it is also its own JSON codec, whose decoder checks
every value against its type. See `pytest_hricdv.results.model` for the rules that all records follow.
"""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct

Number = int | float
"""A JSON number. Both types are named so that reading and writing a report keeps `0` and `0.0` apart."""
_MOST = 2**63 - 1
"""The greatest bound that msgspec takes for an integer."""
Count = Annotated[int, Meta(ge=0, le=_MOST)]
NotNegative = Annotated[int, Meta(ge=0, le=_MOST)] | Annotated[float, Meta(ge=0)]
Percent = Annotated[int, Meta(ge=0, le=100)] | Annotated[float, Meta(ge=0, le=100)]
Names = tuple[str, ...]
TestId = Annotated[str, Meta(pattern=r"^[A-Za-z0-9_-]+\Z")]
"""The id of a test, as `generate.abstract` makes it. Files are named after ids: no dot, no slash, nothing invisible."""
ReplayName = Annotated[str, Meta(pattern=r"^[^\x00-\x1f\x7f]*[A-Za-z0-9_-]\.json\Z")]
"""A replay file as it is given to pytest, from the folder where that was started."""


class PlainRecord(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """Base of all records: immutable, built by keywords; a field that has its default is not written."""
