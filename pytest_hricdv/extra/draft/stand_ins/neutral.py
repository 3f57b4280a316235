"""Stand-ins for values of unknown types."""

from __future__ import annotations

import asyncio
from collections.abc import Generator, Iterator
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


class NeutralNumber(Neutral):
    """A number that a device returns; code that takes it for something else gets neutral values of it."""

    def __new__(cls, value: float) -> Self:
        return float.__new__(cls, value)

    def __init__(self, value: float) -> None:
        super().__init__()


class UnknownValue(Neutral):
    """A value that notes what the code takes it for: a truth that it tests, or a text or number that it compares."""

    def __new__(cls, *_: Any, **__: Any) -> UnknownValue:
        return float.__new__(cls)

    def _note_use(self, other: object) -> None:
        raise NotImplementedError

    def _is_stream(self) -> bool:
        """Whether it is waited for as for the next message of a connection: nobody knows what comes."""
        return False

    def __await__(self) -> Generator[Any, Any, Any]:
        yield from asyncio.sleep(REST_OF_RUN_S if self._is_stream() else 0).__await__()
        return self

    async def __anext__(self) -> Any:
        await asyncio.sleep(REST_OF_RUN_S)
        raise StopAsyncIteration

    def __bool__(self) -> bool:
        self._note_use(False)
        return float(self) != 0.0

    def __eq__(self, other: object) -> bool:
        self._note_use(other)
        return float(self) == other

    def __ne__(self, other: object) -> bool:
        return not self == other

    __hash__ = float.__hash__

    def __lt__(self, other: float) -> bool:
        self._note_use(other)
        return float.__lt__(self, other)

    def __gt__(self, other: float) -> bool:
        self._note_use(other)
        return float.__gt__(self, other)

    def __le__(self, other: float) -> bool:
        self._note_use(other)
        return float.__le__(self, other)

    def __ge__(self, other: float) -> bool:
        self._note_use(other)
        return float.__ge__(self, other)
