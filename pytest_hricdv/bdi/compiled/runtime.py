"""What generated code calls."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NoReturn

from pytest_hricdv.bdi.language.arithmetic import OPERATIONS
from pytest_hricdv.bdi.language.terms import ListTerm, Number, String, Structure, Term, number_of

from ..intentions import duration
from .program import Annots, Store


class BailError(Exception):
    """What comes next is left to the interpreter."""


def bail() -> NoReturn:
    """Leave what comes next to the interpreter."""
    raise BailError


def same(value: Term, pattern: Term) -> bool:
    """Whether two terms without variables unify; if their inner annotations could matter, the interpreter decides."""
    if value is pattern or value == pattern:
        return True
    if isinstance(value, (Structure, ListTerm)) and type(value) is type(pattern):
        if _is_plain(value) and _is_plain(pattern):
            return False
        bail()
    return False


def _is_plain(term: Term) -> bool:
    return isinstance(term, Structure) and not term.args and not term.annots


def compute(operator: str, *operands: float) -> float:
    """The value of an operator that does not always have one."""
    try:
        return OPERATIONS[operator](*operands)
    except (ArithmeticError, ValueError):
        bail()


def shown(value: Term) -> str:
    """A value as it is printed: strings without quotes."""
    return value.value if isinstance(value, String) else str(value)


def believed(propositions: Store, name: str) -> tuple[Annots, ...]:
    """The annotations of a proposition, if it is believed."""
    held = propositions.get(name)
    return () if held is None else (held,)


def sources(annots: Annots) -> Iterator[Term]:
    """Where a belief comes from."""
    for annot in annots:
        if isinstance(annot, Structure) and annot.functor == "source" and len(annot.args) == 1:
            yield annot.args[0]


def first_source(annots: Annots) -> Term | None:
    """Where a belief comes from, the first in term order."""
    return next(sources(annots), None)


NAMES: dict[str, object] = {
    "BailError": BailError,
    "Number": Number,
    "Structure": Structure,
    "bail": bail,
    "believed": believed,
    "compute": compute,
    "duration": duration,
    "first_source": first_source,
    "number_of": number_of,
    "same": same,
    "shown": shown,
    "sources": sources,
}
"""The names that generated code knows besides those of its own objects."""
