"""Which classes can be messages, and which fields their instances have."""

from __future__ import annotations

import dataclasses

FORMS = "dataclasses, named tuples, or classes of attrs, msgspec or pydantic"
"""What can be one, in words."""


def fields_of(kind: object) -> tuple[str, ...] | None:
    """The fields of the instances of a class, in their order; None where it can be no message.

    Nothing but what the class itself has is asked, so that none of these libraries is needed.

    >>> from typing import NamedTuple
    >>> class Light(NamedTuple):
    ...     level: float
    >>> fields_of(Light), fields_of(str)
    (('level',), None)
    """
    if not isinstance(kind, type):
        return None
    if dataclasses.is_dataclass(kind):
        return tuple(member.name for member in dataclasses.fields(kind))
    if issubclass(kind, tuple) and hasattr(kind, "_fields"):
        return tuple(kind._fields)
    attributes = getattr(kind, "__attrs_attrs__", None)
    if attributes is not None:
        return tuple(attribute.name for attribute in attributes)
    for name in ("__struct_fields__", "__pydantic_fields__"):  # of msgspec, of pydantic 2
        fields = getattr(kind, name, None)
        if fields is not None:
            return tuple(fields)
    return None


def is_message(value: object) -> bool:
    """Whether a value is an instance of such a class."""
    return fields_of(type(value)) is not None
