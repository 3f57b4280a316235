from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class TeaWish:
    room: str
    sort: Literal["green", "black", "mint"]
    cups: int = 1


@dataclass(frozen=True)
class CupTaken:
    room: str


@dataclass(frozen=True)
class SpillSeen:
    severity: float


@dataclass(frozen=True)
class CartSays:
    text: str


@dataclass(frozen=True)
class CartState:
    name: str
