"""Somebody at the table orders, waits, walks about and sits down again, until there are no more orders."""

from __future__ import annotations

from collections.abc import Mapping

START = "sitting"

_ORDERS = ("fridge", "sink", "feed", "clean", "whatever", "chase", "opendoor", "recharge")
_PLACES = ("table", "tv", "doorway", "fridge", "kitchen", "sink", "charger")
_ANYWHERE = ("call_dog", "wait", "rest", *_ORDERS, *(f"ask {order}" for order in _ORDERS))
_WALKS = {f"walk {place}": "standing" for place in _PLACES}

FOLLOWS: Mapping[str, Mapping[str, str]] = {
    "sitting": {**dict.fromkeys(_ANYWHERE, "sitting"), **_WALKS, "ended": "over"},
    "standing": {**dict.fromkeys(_ANYWHERE, "standing"), **_WALKS, "sit": "sitting"},
    "over": {},
}
