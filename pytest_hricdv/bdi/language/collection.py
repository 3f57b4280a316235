"""Sets, maps and queues, as in Jason 3 (`SetTerm`, `MapTerm`, `QueueTerm`): the only terms that can change.

All beliefs and goals with such a term share it. Internal actions (`bdi.actions.collections`) make and change them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, ClassVar, Self

from pytest_hricdv.bdi.language.limits import CHARACTERS, check_text, spend

READING = 50
"""Units of work (see `limits`) that each reading costs, besides one per term: reading a small collection takes 20 us,
and sets in sets can be read for ever."""


class CollectionTerm:
    """A set, map or queue of terms.

    Two of them are the same value only if they are the same object: what is in them changes while they are parts of
    beliefs and goals. Unification and ``==`` compare the content of sets, as in Jason: see :meth:`matches`.

    Args:
        order: the sort key of its terms; None for a queue without priorities.
    """

    __slots__ = ("content", "order")
    NAME: ClassVar[str]
    content: Any

    def __init__(self, order: Callable[[Any], Any] | None) -> None:
        self.content = {}
        self.order = order

    def __len__(self) -> int:
        return len(self.content)

    def items(self) -> tuple[Any, ...]:
        """The terms in it, in the order in which they are found; of a map, the keys."""
        spend(READING + len(self.content))
        return tuple(sorted(self.content, key=self.order))

    def matches(self, other: object) -> bool:
        """Whether it unifies with another term."""
        return self is other

    def copy(self) -> Self:
        """Another one with the same terms."""
        duplicate = type(self)(self.order)
        duplicate.content = self.content.copy()
        return duplicate


class SetTerm(CollectionTerm):
    """A set, in the order of terms."""

    __slots__ = ()
    NAME = "set"
    content: dict[Any, None]

    def add(self, terms: Iterable[Any]) -> None:
        """Put terms in that are not yet."""
        for term in terms:
            spend(1)
            self.content[term] = None

    def keep(self, wanted: Callable[[Any], bool]) -> None:
        """Take out all terms but those wanted."""
        self.content = {term: None for term in self.content if wanted(term)}

    def matches(self, other: object) -> bool:
        return isinstance(other, SetTerm) and self.content.keys() == other.content.keys()

    def __str__(self) -> str:
        return f"{{{_join(self.items(), ',')}}}"


class MapTerm(CollectionTerm):
    """A map from keys to values, in the order of its keys."""

    __slots__ = ()
    NAME = "map"
    content: dict[Any, Any]

    def __str__(self) -> str:
        return f"{{{_join((f'{key}->{self.content[key]}' for key in self.items()), ',')}}}"


class QueueTerm(CollectionTerm):
    """A queue: first in, first out; with an order, the least first."""

    __slots__ = ()
    NAME = "queue"
    content: list[Any]
    """The terms as Java keeps them, which a list of them and its text show: of priorities, in a binary heap."""

    def __init__(self, order: Callable[[Any], Any] | None = None) -> None:
        super().__init__(order)
        self.content = []

    def items(self) -> tuple[Any, ...]:
        spend(READING + len(self.content))
        return tuple(self.content)

    def add(self, term: Any) -> None:
        """Put a term in."""
        spend(1)
        self.content.append(term)
        order, place = self.order, len(self.content) - 1
        while order is not None and place:
            parent = (place - 1) // 2
            if order(term) >= order(self.content[parent]):
                break
            self._swap(place, parent)
            place = parent

    def remove(self) -> Any:
        """Take out the first term; raises IndexError if there is none."""
        spend(1 + len(self.content) // CHARACTERS)
        if self.order is None or len(self.content) < 2:
            return self.content.pop(0)
        first, self.content[0] = self.content[0], self.content.pop()
        place, order = 0, self.order
        while children := range(2 * place + 1, min(2 * place + 3, len(self.content))):
            least = min(children, key=lambda child: order(self.content[child]))
            if order(self.content[place]) <= order(self.content[least]):
                break
            self._swap(place, least)
            place = least
        return first

    def _swap(self, place: int, other: int) -> None:
        self.content[place], self.content[other] = self.content[other], self.content[place]

    def __str__(self) -> str:
        return f"[{_join(self.items(), ', ')}]"


def _join(items: Iterable[Any], between: str) -> str:
    texts = [str(item) for item in items]
    check_text(sum(map(len, texts)))
    return between.join(texts)
