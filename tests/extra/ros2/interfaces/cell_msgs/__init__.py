"""Interfaces of a cell, with classes as `rosidl` generates them: a slot for each field, which has a default."""

from __future__ import annotations

import copy
from typing import Any, ClassVar


class _Generated:
    __slots__ = ()
    DEFAULTS: ClassVar[dict[str, Any]]

    def __init__(self, **values: Any) -> None:
        self._check_fields = False
        for name, default in self.DEFAULTS.items():
            setattr(self, f"_{name}", values.get(name, copy.deepcopy(default)))

    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]:
        return dict.fromkeys(cls.DEFAULTS, "any")


def _field(name: str) -> property:
    slot = f"_{name}"
    return property(lambda self: getattr(self, slot), lambda self, value: setattr(self, slot, value))


def generated(module: str, name: str, **defaults: Any) -> Any:
    """A class of messages with these fields."""
    slots = (*(f"_{field}" for field in defaults), "_check_fields")
    fields = {field: _field(field) for field in defaults}
    return type(name, (_Generated,), {"__slots__": slots, "__module__": module, "DEFAULTS": defaults, **fields})
