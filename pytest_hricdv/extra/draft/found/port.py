"""What code is handed: a port, what the code does with it, and what is said and told there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from pytest_hricdv.extra.draft.found.place import Place


@dataclass(frozen=True)
class Part:
    """A field of an object, or an item of a tuple, that a port says or is told.

    Args:
        name: of the field, or what the code calls the item; empty where it has no name.
        kind: "bool", "float", "str", "floats" (a tuple of any length); empty where nothing is known.
        made: source text of a neutral value; empty where it has a default.
        compared: numbers that the code compares it with.
    """

    name: str
    kind: str
    made: str
    compared: tuple[float, ...] = ()


@dataclass(frozen=True)
class Operation:
    """What the code does with a port: a method that it calls, or an attribute that it reads or sets.

    `returns` is the source text of the annotation, or "bool", "float", "text", concluded from the use; empty: unknown.
    `compared` are the numbers that the code compares it with, where they are constants; `made` is the source text of
    a neutral value of what it returns, where its type says one, and `needs` the names in it, as (module, name).
    `told` are the kinds of the arguments, or of what an attribute is set to: "bool", "float", "str"; empty: unknown.
    `usual` is the side of these numbers, "low" or "high", on which the code needs to do nothing; empty: unknown.
    `parts` are those of the object or tuple that it returns, and `told_parts` those of each argument that is an object.
    """

    name: str
    kind: Literal["method", "attribute"]
    arguments: tuple[str, ...]
    returns: str
    place: Place
    is_async: bool = False
    is_set: bool = False
    compared: tuple[float, ...] = ()
    usual: str = ""
    made: str = ""
    needs: tuple[tuple[str, str], ...] = ()
    told: tuple[str, ...] = ()
    parts: tuple[Part, ...] = ()
    told_parts: tuple[tuple[Part, ...], ...] = ()


@dataclass(frozen=True)
class Port:
    """A parameter of the entry.

    Args:
        name: of the parameter.
        role: "bus", "clock", "publish" (a function that is called with each message), "queue", "reader", "writer",
            "parameter" (a number or text), "device" (hardware, or whatever else the code is handed).
        annotation: source text; empty where there is none.
        default: source text; empty where there is none.
        operations: what the code does with it.
        place: of the parameter.
        direction: of a queue: heard or said; empty where it is not known.
        keyword: whether it can be handed over by name only.
        made: source text of a neutral value of its type, where this says one.
        needs: the names in it, as (module, name).
    """

    name: str
    role: str
    annotation: str
    default: str
    operations: tuple[Operation, ...]
    place: Place
    direction: str = ""
    keyword: bool = False
    made: str = ""
    needs: tuple[tuple[str, str], ...] = ()
