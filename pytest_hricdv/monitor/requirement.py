"""Requirements and the TOML file that they are written in."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from pytest_hricdv.monitor.errors import FormulaSource, RequirementError, nearest
from pytest_hricdv.monitor.formula import Formula
from pytest_hricdv.monitor.vocabulary import Vocabulary

_KEYS = ("title", "source", "formula", "shows")


@dataclass(frozen=True)
class Requirement:
    """One requirement.

    Attributes:
        id: the name of its table in the file, such as `R1`.
        title: what it says, in a sentence.
        source: where it comes from (a standard's clause, a paper); may be empty.
        text: the formula as written, for reports.
        formula: the formula as data.
        shows: numeric signals, beside those that the formula reads, whose value a violation tells, too: of a violation
            that lasts, the one largest in size meanwhile. Verdicts do not depend on them.
    """

    id: str
    title: str
    source: str
    text: str
    formula: Formula
    shows: tuple[str, ...] = ()


def load_requirements(
    given: str | PathLike[str] | Sequence[Requirement], vocabulary: Vocabulary
) -> tuple[Requirement, ...]:
    """The requirements of a TOML file, in the order of the file: one table each, keys as of `Requirement`.

    Args:
        given: the file, shown in errors as given; or requirements that were built in Python (see `build`).
        vocabulary: the signals and messages that formulas may speak of.

    Raises:
        RequirementError: the file cannot be read, is no TOML, has no requirement or one with missing or unknown keys,
            or a formula is wrong; of requirements that were built, there is none, or two have one id.
    """
    if not isinstance(given, str | PathLike):
        return _checked(given, vocabulary)
    document = _read(given)
    try:
        tables = tomllib.loads(document)
    except tomllib.TOMLDecodeError as error:
        raise RequirementError(f"{given}: not TOML: {error}") from None
    if not tables:
        raise RequirementError(
            f'{given}: no requirement in this file\nexpected a table each: [R1], title = "...", formula = "..."'
        )
    return tuple(_requirement(str(given), document, name, table, vocabulary) for name, table in tables.items())


def _checked(built: Sequence[Requirement], vocabulary: Vocabulary) -> tuple[Requirement, ...]:
    if not built:
        raise RequirementError("no requirement; expected at least one")
    ids = [requirement.id for requirement in built]
    twice = [name for name in ids if ids.count(name) > 1]
    if twice:
        raise RequirementError(f"requirement {twice[0]} is there twice; expected an id of its own for each")
    for requirement in built:
        check_requirement(requirement, vocabulary)
    return tuple(built)


def check_requirement(requirement: Requirement, vocabulary: Vocabulary) -> None:
    """Check a requirement that was built in Python as its text would be checked in a file.

    Raises:
        RequirementError: an unknown name (the nearest known one is offered), a type that does not fit, or a condition
            that could never hold where it stands; the caret stands in the formula's text.
    """
    _check_shown(f"requirement {requirement.id}", requirement.shows, vocabulary)
    read = parse_formula(requirement.text, vocabulary, FormulaSource(requirement.text, requirement.id))
    if read != requirement.formula:
        raise RequirementError(
            f"requirement {requirement.id}: its text and its formula differ\n"
            f"text:    {requirement.text}\nformula: {requirement.formula}"
        )


def parse_formula(text: str, vocabulary: Vocabulary, source: FormulaSource | None = None) -> Formula:
    """The formula that a text stands for.

    Args:
        text: `always(antecedent -> response)`.
        vocabulary: the signals and messages that it may speak of.
        source: where the text comes from, for errors; by default the text alone.

    Raises:
        RequirementError: the text is no formula over this vocabulary.
    """
    # Here, because these import lark: a test session without requirements should not pay for it.
    from pytest_hricdv.monitor.elaborate import elaborate
    from pytest_hricdv.monitor.parser import parse

    source = source or FormulaSource(text)
    return elaborate(parse(source), source, vocabulary)


def _read(path: str | PathLike[str]) -> str:
    try:
        # Windows line ends become plain ones, as TOML makes them within multi-line formulas.
        return Path(path).read_text(encoding="utf-8")
    except OSError as error:
        raise RequirementError(f"{path}: cannot read the requirements: {error.strerror or error}") from None
    except UnicodeDecodeError as error:
        raise RequirementError(f"{path}: not UTF-8 text (byte {error.start}); TOML files are UTF-8") from None


def _requirement(path: str, document: str, name: str, table: object, vocabulary: Vocabulary) -> Requirement:
    where = f"{path}: requirement {name}"
    if not isinstance(table, dict):
        raise RequirementError(f"{path}: {name!r} stands outside a requirement; expected a table each, such as [R1]")
    for key, value in table.items():
        if key not in _KEYS:
            raise RequirementError(f"{where}: unknown key {key!r}\n{nearest(key, _KEYS)}")
        if key == "shows":
            _check_shown(where, value, vocabulary)
        elif not isinstance(value, str) or (not value.strip() and key != "formula"):
            raise RequirementError(f"{where}: {key!r} has to be a text, got {value!r}")
    for key in ("title", "formula"):
        if key not in table:
            raise RequirementError(
                f"{where}: no {key!r}\nexpected the keys title and formula, and source if there is one"
            )
    text = table["formula"]
    formula = parse_formula(text, vocabulary, FormulaSource(text, name, path, document))
    return Requirement(
        name, table["title"], table.get("source", ""), text.strip(), formula, tuple(table.get("shows", ()))
    )


def _check_shown(where: str, names: object, vocabulary: Vocabulary) -> None:
    numeric = [name for name, kind in vocabulary.signals.items() if kind is float]
    if not isinstance(names, list | tuple):
        raise RequirementError(f"{where}: 'shows' has to be a list of signals, got {names!r}")
    for name in names:
        if name not in numeric:
            raise RequirementError(
                f"{where}: shows {name!r}, which is no numeric signal\n{nearest(str(name), numeric)}"
            )
