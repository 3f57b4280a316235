"""The contract of `report.json`: its JSON Schema, and a check that needs no further package.

The schema ships for whoever reads reports by machine. The plugin itself must not depend on a schema library only to say
"this report is cut off", so `faults` understands the few keywords that the schema uses, and the tests hold it against
a full implementation.
"""

import json
import math
from collections.abc import Iterator, Mapping
from importlib.resources import files
from typing import Any, cast

SCHEMA = "hricdv-report/1"

_NO_RULES = {"$ref", "description"}
_TYPES: dict[str, tuple[type, ...]] = {
    "object": (Mapping,),
    "array": (list, tuple),
    "string": (str,),
    "boolean": (bool,),
    "null": (type(None),),
    "number": (int, float),
}
_KINDS: dict[type, tuple[str, ...]] = {
    dict: ("object",),
    list: ("array",),
    str: ("string",),
    bool: ("boolean",),
    type(None): ("null",),
    int: ("integer", "number"),
    float: ("number",),
}


def schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of the report, as it ships with the plugin."""
    text = files(__package__).joinpath("report-1.schema.json").read_text(encoding="utf-8")
    parsed: dict[str, Any] = json.loads(text)
    return parsed


def faults(value: object, contract: Mapping[str, Any] | None = None, name: str = "report") -> list[str]:
    """Where a report breaks the contract, as `report.tests[3].outcome: ...`; empty when it keeps it.

    Or any other value with this name, against a contract of its own that uses the same keywords of JSON Schema.
    """
    root = schema() if contract is None else contract
    return list(_faults(value, root, name, root))


def _faults(value: object, rule: Mapping[str, Any], place: str, root: Mapping[str, Any]) -> Iterator[str]:
    if not rule and _finite(value):
        return  # nothing is asked of it, as of half of a large report
    if "$ref" in rule:
        yield from _faults(value, _referred(rule["$ref"], root), place, root)
        if rule.keys() <= _NO_RULES:
            return  # or all that is in the value would be looked through once more, for nothing
    types = rule.get("type")
    if types is not None and not _is_one_of(value, [types] if isinstance(types, str) else types):
        yield f"{place}: expected {types}, found {_shown(value)}"
        return
    if "const" in rule and value != rule["const"]:
        yield f"{place}: expected {rule['const']!r}, found {_shown(value)}"
    if "enum" in rule and value not in rule["enum"]:
        yield f"{place}: expected one of {', '.join(rule['enum'])}, found {_shown(value)}"
    if isinstance(value, Mapping):
        yield from _object_faults(value, rule, place, root)
    elif isinstance(value, list | tuple):
        yield from _array_faults(value, rule, place, root)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield from _range_faults(value, rule, place)


def _object_faults(
    value: Mapping[str, Any], rule: Mapping[str, Any], place: str, root: Mapping[str, Any]
) -> Iterator[str]:
    yield from (f"{place}: {key!r} is missing" for key in rule.get("required", ()) if key not in value)
    known: Mapping[str, Any] = rule.get("properties", {})
    others = rule.get("additionalProperties", {})
    for key, item in value.items():
        yield from _faults(item, known.get(key, others), f"{place}.{key}", root)


def _array_faults(
    value: list[Any] | tuple[Any, ...], rule: Mapping[str, Any], place: str, root: Mapping[str, Any]
) -> Iterator[str]:
    if not rule.get("minItems", 0) <= len(value) <= rule.get("maxItems", math.inf):
        yield f"{place}: {len(value)} items, expected {rule.get('minItems')} to {rule.get('maxItems')}"
    items = rule.get("items", {})
    if items == {"type": "string"} and all(isinstance(item, str) for item in value):
        return  # most of a large report is lists of names
    for index, item in enumerate(value):
        yield from _faults(item, items, f"{place}[{index}]", root)


def _range_faults(value: float, rule: Mapping[str, Any], place: str) -> Iterator[str]:
    if not math.isfinite(value):
        yield f"{place}: {value} is not a number that JSON has; say null where there is no figure"
    elif not rule.get("minimum", -math.inf) <= value <= rule.get("maximum", math.inf):
        yield f"{place}: {value} is outside of {rule.get('minimum')} to {rule.get('maximum', 'infinity')}"


def _finite(value: object) -> bool:
    """Whether all numbers in a value are."""
    kind = type(value)
    if kind is float:
        return math.isfinite(cast(float, value))
    if kind is dict:
        return all(map(_finite, cast("dict[str, object]", value).values()))
    return all(map(_finite, cast("list[object]", value))) if kind in (list, tuple) else True


def _referred(reference: str, root: Mapping[str, Any]) -> Mapping[str, Any]:
    found: Mapping[str, Any] = root["$defs"][reference.removeprefix("#/$defs/")]
    return found


def _is_one_of(value: object, names: list[str]) -> bool:
    kinds = _KINDS.get(type(value), ())  # of what JSON is read as; the rest takes longer
    return any(name in kinds for name in names) or any(_is(value, name) for name in names)


def _is(value: object, name: str) -> bool:
    if isinstance(value, bool):
        return name == "boolean"  # Python counts True as a number, JSON does not
    if name == "integer":
        return isinstance(value, int) or (isinstance(value, float) and value.is_integer())
    return isinstance(value, _TYPES[name])


def _shown(value: object) -> str:
    shown = repr(value)
    return shown if len(shown) <= 60 else f"{shown[:57]}..."
