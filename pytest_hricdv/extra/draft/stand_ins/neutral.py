"""`Neutral` and `Lenient`: stand-ins for values and methods of which nothing is known; others derive from them."""

from __future__ import annotations

from collections.abc import Iterator
from types import FunctionType
from typing import Any, Self

REST_OF_RUN_S = 10_000.0
"""Longer than any run."""


class Neutral(float):
    """A neutral value of an unknown type: 0.0, which has each attribute, can be called, and is empty."""

    def __new__(cls, *_: Any, **__: Any) -> Self:
        return float.__new__(cls)

    def __init__(self, *_: Any, **named: Any) -> None:
        self.__dict__.update(named)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return Neutral()

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """Neutral; a decorator leaves a function as it is."""
        is_decorator = len(arguments) == 1 and not named and isinstance(arguments[0], FunctionType)
        return arguments[0] if is_decorator else Neutral()

    def __await__(self) -> Iterator[Any]:
        return iter(())

    def __getitem__(self, _: Any) -> Any:
        return Neutral()

    def __setitem__(self, _: Any, __: Any) -> None:
        return None

    def __contains__(self, _: Any) -> bool:
        return False

    def __iter__(self) -> Iterator[Any]:
        return iter(())

    def __len__(self) -> int:
        return 0

    def __index__(self) -> int:
        return 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        return None

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        return None

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> Any:
        raise StopAsyncIteration


class Lenient:
    """An object that has each method: what it does not define itself is neutral."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return Neutral()
