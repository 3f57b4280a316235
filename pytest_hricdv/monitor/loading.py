"""`load_requirements`: requirements from a TOML file or from Python, parsed and checked against a vocabulary.

`RunContext` calls it once per session, with the testbench's vocabulary. `parse_formula` and `parse_condition` parse
one text; `load_definitions` adds the definitions of a file to a vocabulary.
"""

from __future__ import annotations

import datetime
from collections.abc import Iterable, Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_hricdv._base.input_file import MAX_TOML_BYTES, MalformedError, from_toml, read_text
from pytest_hricdv._base.message import nearest, quote
from pytest_hricdv.monitor.formula import Formula
from pytest_hricdv.monitor.node import PastFormula
from pytest_hricdv.monitor.requirement import FormulaSource, Requirement, RequirementError
from pytest_hricdv.monitor.vocabulary import Vocabulary

if TYPE_CHECKING:
    from pytest_hricdv.monitor.pattern_parser import RequirementParser

_KEYS = ("title", "source", "formula", "pattern", "shows", "group", "suggested", "accepted_by", "accepted_on")
"""The keys in the table of a requirement."""
_DEFINITIONS = "definitions"


def load_requirements(
    source: str | PathLike[str] | Sequence[Requirement], vocabulary: Vocabulary
) -> tuple[Requirement, ...]:
    """The requirements of a TOML file, in the order of the file: one table each, with the keys of `Requirement`.

    Args:
        source: the file, named in errors as it is here; or requirements that were built in Python (see `build`).
        vocabulary: the signals and messages that formulas may use.

    Raises:
        RequirementError: the file cannot be read, is not TOML, has no requirement, or has one with missing or unknown
            keys; or a formula is wrong. For requirements built in Python: there is none, or two have the same id.
    """
    if not isinstance(source, str | PathLike):
        return _check_all(source, vocabulary)
    document, tables = _read(source)
    vocabulary = _define(str(source), document, tables.pop(_DEFINITIONS, {}), vocabulary)
    if not tables:
        raise RequirementError(
            f'{source}: no requirement in this file\nexpected a table each: [R1], title = "...", formula = "..."'
        )
    return tuple(_requirement(str(source), document, name, table, vocabulary) for name, table in tables.items())


def load_definitions(source: str | PathLike[str] | Sequence[Requirement], vocabulary: Vocabulary) -> Vocabulary:
    """The vocabulary with the definitions of a file of requirements, for conditions outside of the file.

    Args:
        source: as for `load_requirements`; requirements that were built in Python have no definitions.
        vocabulary: the signals and messages that definitions may use.

    Raises:
        RequirementError: the file cannot be read or is not TOML, or a definition is wrong.
    """
    if not isinstance(source, str | PathLike):
        return vocabulary
    document, tables = _read(source)
    return _define(str(source), document, tables.get(_DEFINITIONS, {}), vocabulary)


def check_requirement(requirement: Requirement, vocabulary: Vocabulary) -> None:
    """Check a requirement that was built in Python as its text would be checked in a file.

    Raises:
        RequirementError: an unknown name (the nearest known one is offered), a type error, or a condition that can
            never hold where it stands; the caret marks the place in the formula's text.
    """
    _check_shows(f"requirement {requirement.id}", requirement.shows, vocabulary)
    parsed = parse_formula(requirement.text, vocabulary, FormulaSource(requirement.text, requirement.id, is_built=True))
    if parsed != requirement.formula:
        raise RequirementError(
            f"requirement {requirement.id}: its text and its formula differ\n"
            f"text:    {requirement.text}\nformula: {requirement.formula}"
        )


def parse_formula(text: str, vocabulary: Vocabulary, source: FormulaSource | None = None) -> Formula:
    """Parse a formula and check its names and types.

    Args:
        text: `always(antecedent -> response)`.
        vocabulary: the signals and messages that it may use.
        source: where the text comes from, for errors; by default the text alone.

    Raises:
        RequirementError: the text is not a formula over this vocabulary.
    """
    return _parser()(source or FormulaSource(text), vocabulary).formula()


def parse_condition(text: str, vocabulary: Vocabulary, source: FormulaSource | None = None) -> PastFormula:
    """Parse a condition outside of a requirement: a formula about the present and the past, without a response.

    `MonitorSet.watch` evaluates it during a run, `logged.watch` on a logged run.

    Args:
        text: for instance `state == "Move_hand" & once[0:2](on(request))`.
        vocabulary: the signals and messages that it may use.
        source: where the text comes from, for errors; by default the text alone. `FormulaSource(text, owner="...")`
            names what the condition belongs to.

    Raises:
        RequirementError: the text is not a condition over this vocabulary.

    >>> vocabulary = Vocabulary(messages={"state": {"name": str}})
    >>> str(parse_condition("state == 'Move_hand'", vocabulary))
    'state.name == "Move_hand"'
    """
    return _parser()(source or FormulaSource(text, owner="condition"), vocabulary).condition()


def _parser() -> type[RequirementParser]:
    """The parser, imported with the first text: it needs lark, which sessions without requirements should not load."""
    from pytest_hricdv.monitor.pattern_parser import RequirementParser

    return RequirementParser


def _check_all(built: Sequence[Requirement], vocabulary: Vocabulary) -> tuple[Requirement, ...]:
    if not built:
        raise RequirementError("no requirement; expected at least one")
    ids = [requirement.id for requirement in built]
    repeated = [name for name in ids if ids.count(name) > 1]
    if repeated:
        raise RequirementError(f"requirement {repeated[0]} is there twice; expected a different id for each")
    for requirement in built:
        check_requirement(requirement, vocabulary)
    return tuple(built)


def _read(path: str | PathLike[str]) -> tuple[str, dict[str, Any]]:
    """The text of a file, and its tables."""
    try:
        document = read_text(Path(path), MAX_TOML_BYTES)
        tables = from_toml(document)
    except (FileNotFoundError, MalformedError) as error:
        fault = ": no such file" if isinstance(error, FileNotFoundError) else error
        raise RequirementError(f"{path}{fault}; expected a TOML file of requirements") from None
    return document, tables


def _define(path: str, document: str, table: object, vocabulary: Vocabulary) -> Vocabulary:
    """The vocabulary with the definitions of a table: name -> text, or a number."""
    if not isinstance(table, dict):
        expected = f'expected [{_DEFINITIONS}] with lines name = "..."'
        raise RequirementError(f"{path}: {_DEFINITIONS} is not a table; {expected}")
    sources = {}
    for name, text in table.items():
        if isinstance(text, bool) or not isinstance(text, str | int | float):
            raise RequirementError(f"{path}: definition {name}: expected a string or a number, got {quote(text)}")
        sources[name] = FormulaSource(str(text), path=path, document=document, definition=name)
    if not sources:
        return vocabulary
    try:
        return _parser().define(sources, vocabulary)
    except RequirementError:
        raise
    except ValueError as error:
        raise RequirementError(f"{path}: {error}") from None


def _requirement(path: str, document: str, name: str, table: object, vocabulary: Vocabulary) -> Requirement:
    if not name.strip():
        raise RequirementError(f"{path}: requirement {quote(name)} has no name; expected one such as [R1]")
    where = f"{path}: requirement {name}"
    if not isinstance(table, dict):
        raise RequirementError(
            f"{path}: {quote(name)} is outside of a requirement; expected a table each, such as [R1]"
        )
    for key, value in table.items():
        _check_key(where, key, value, vocabulary)
    kind = "pattern" if "pattern" in table and "formula" not in table else "formula"
    for key in ("title", kind):
        if key not in table:
            raise RequirementError(
                f"{where}: no {key!r}\nexpected the keys title and formula, or title and pattern; "
                "and source and group if there are such"
            )
    if kind == "formula" and "pattern" in table:
        raise RequirementError(f"{where}: both 'formula' and 'pattern'\nexpected one of them: a pattern is a formula")
    source = FormulaSource(table[kind], name, path, document, key=kind)
    text, formula, names = _formula(source, vocabulary, "source" in table)
    meanings = ((vocabulary.definitions[definition].meaning, definition) for definition in names)
    return Requirement(
        id=name,
        title=table["title"],
        source=table.get("source", ""),
        text=text,
        formula=formula,
        shows=tuple(table.get("shows", ())),
        group=table.get("group", ""),
        suggested=table.get("suggested", ""),
        accepted_by=table.get("accepted_by", ""),
        accepted_on=str(table.get("accepted_on", "")),  # in TOML, a date needs no quotation marks
        names=tuple((meaning, definition) for meaning, definition in meanings if isinstance(meaning, PastFormula)),
    )


def _formula(source: FormulaSource, vocabulary: Vocabulary, has_source: bool) -> tuple[str, Formula, Sequence[str]]:
    """A formula or pattern for reports, with what it means; as data; and the definitions that explain the formula."""
    text, parser = source.formula.strip(), _parser()(source, vocabulary)
    if source.key == "pattern":
        formula = parser.pattern(has_source=has_source)
        return f"{text}\nmeans {formula}", formula, ()
    formula = parser.formula()
    names = _with_parts(parser.used, vocabulary)
    lines = [f"{name} = {vocabulary.definitions[name].text}" for name in names]
    return text + "\nwhere " + ";\n      ".join(lines) if lines else text, formula, names


def _with_parts(used: Iterable[str], vocabulary: Vocabulary) -> list[str]:
    """The definitions that are used, and those that they are made of."""
    needed = set(used)
    while more := {use for name in needed for use in vocabulary.definitions[name].uses} - needed:
        needed |= more
    # A definition stands before those that it is made of.
    return [name for name in reversed([*vocabulary.definitions]) if name in needed]


def _check_key(where: str, key: str, value: object, vocabulary: Vocabulary) -> None:
    if key not in _KEYS:
        raise RequirementError(f"{where}: unknown key {quote(key)}{nearest(key, _KEYS)}")
    if key == "shows":
        _check_shows(where, value, vocabulary)
    elif key == "accepted_on":
        _check_date(where, value)
    elif not isinstance(value, str) or (not value.strip() and key not in ("formula", "pattern")):
        raise RequirementError(f"{where}: {quote(key)} has to be a string, got {quote(value)}")


def _check_date(where: str, value: object) -> None:
    try:
        is_date = not isinstance(value, datetime.datetime) and bool(datetime.date.fromisoformat(str(value)))
    except ValueError:
        is_date = False
    if not is_date:
        raise RequirementError(f"{where}: 'accepted_on' has to be a date, as 2026-11-26, got {quote(value)}")


def _check_shows(where: str, names: object, vocabulary: Vocabulary) -> None:
    numeric = [name for name, kind in vocabulary.signals.items() if kind is float]
    if not isinstance(names, list | tuple):
        raise RequirementError(f"{where}: 'shows' has to be a list of signals, got {quote(names)}")
    for name in names:
        if name not in numeric:
            suggestion = nearest(str(name), numeric)
            raise RequirementError(f"{where}: shows {quote(name)}, which is not a numeric signal{suggestion}")
