"""What is known of a value that has no class: texts, keys of dicts, places of tuples."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from pytest_hricdv.extra.draft.found.place import Place
from pytest_hricdv.extra.draft.reading.naming import unit_of


@dataclass
class PlainValue:
    """What is known of a value.

    Args:
        place: of its first use.
        texts: that it is compared with, or is, each with its place.
        keys: of a dict, each with what is known of its content.
        items: of a tuple, by their numbers, likewise.
        names: of the items, where the code unpacks them.
        is_text: whether something is done with it that only texts can do.
        is_number: likewise of numbers.
        is_bool: likewise of truth values.
        is_json: whether a text of JSON holds it.
        is_object: whether attributes of it are read: then it is of a class.
        is_bytes: whether it is a text as bytes.
        attributes: that are read of it, each with what is known of its content.
        numbers: that it is compared with, each with its place.
        heads: texts that it can begin with, each with its place.
        rest: the words that are read after them.
    """

    place: Place
    texts: dict[str, Place] = field(default_factory=dict)
    keys: dict[str, PlainValue] = field(default_factory=dict)
    items: dict[int, PlainValue] = field(default_factory=dict)
    names: dict[int, str] = field(default_factory=dict)
    is_text: bool = False
    is_number: bool = False
    is_bool: bool = False
    is_json: bool = False
    is_object: bool = False
    is_bytes: bool = False
    attributes: dict[str, PlainValue] = field(default_factory=dict)
    numbers: dict[float, Place] = field(default_factory=dict)
    heads: dict[str, Place] = field(default_factory=dict)
    rest: tuple[str, ...] = ()

    def finish(self) -> PlainValue:
        """The same, with a text for each beginning."""
        for text, place in self.heads.items():
            words = self.rest[max(len(text.split()), 1) - 1 :] if not text.endswith((" ", ":", "=")) else self.rest
            glue = "" if text.endswith((":", "=")) else " "
            self.texts.setdefault(glue.join([text.rstrip() if glue else text, *words]), place)
        for part in (*self.keys.values(), *self.items.values(), *self.attributes.values()):
            part.finish()
        return self

    @property
    def is_known(self) -> bool:
        """Whether anything says what it is."""
        return bool(self.texts or self.keys or self.items or self.is_text or self.is_number or self.is_bool)

    @property
    def kind(self) -> str:
        """As requirements see it: "str", "bool" or "float"; a text where nothing is known."""
        if self.texts or self.is_text:
            return "str"
        return "float" if self.is_number else "bool" if self.is_bool else "str"

    def key(self, name: str, place: Place) -> PlainValue:
        """The content of a key, new where there was none."""
        return self.keys.setdefault(name, PlainValue(place, is_number=bool(unit_of(name))))

    def attribute(self, name: str, place: Place) -> PlainValue:
        """The content of an attribute, likewise."""
        return self.attributes.setdefault(name, PlainValue(place, is_number=bool(unit_of(name))))

    def item(self, number: int, place: Place) -> PlainValue:
        """The item of a tuple, likewise."""
        return self.items.setdefault(number, PlainValue(place))


def sentences(words: PlainValue) -> dict[str, Place]:
    """Texts that begin with a word that the code looks for, followed by those that it reads then."""
    if 0 not in words.items:
        return {}
    rest = ["1" if item.is_number else next(iter(item.texts), "word")
            for number, item in sorted(words.items.items()) if number and item.is_known]  # fmt: skip
    return {" ".join([text, *rest]): place for text, place in words.items[0].texts.items()}


def words_after(words: PlainValue) -> tuple[str, ...]:
    """Those that are read after the first one."""
    later = sorted(words.items.items())
    return tuple("1" if item.is_number else next(iter(item.texts), "word") for number, item in later if number)


def fields_of(
    value: PlainValue, path: tuple[str | int, ...] = ()
) -> Iterator[tuple[tuple[str | int, ...], PlainValue]]:
    """The plain contents of a value, each with the keys and numbers that lead to it."""
    parts: list[tuple[str | int, PlainValue]] = [*value.keys.items()] or [*sorted(value.items.items())]
    if not parts or len(path) > 3:
        yield path, value
        return
    for key, content in parts:
        yield from fields_of(content, (*path, key))
