"""`read_requirements` reads requirements of other tools, for `hricdv evidence`: ReqIF, CSV, or `needs.json`."""

from __future__ import annotations

import csv
import io
import re
import zlib
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any
from zipfile import BadZipFile, ZipFile

from msgspec import Struct

from pytest_hricdv._base.input_file import MAX_BYTES, MalformedError, from_json, read_bytes, read_text
from pytest_hricdv._base.record import PlainRecord
from pytest_hricdv.results.codec import ReportError


class ListedRequirement(PlainRecord, frozen=True, kw_only=True):
    """A requirement of a list: its id, and for people its title, text and source."""

    id: str
    title: str = ""
    text: str = ""
    source: str = ""


def read_requirements(path: Path) -> tuple[ListedRequirement, ...]:
    """The requirements of a file, in its order.

    Args:
        path: `.reqif` or `.reqifz` (need the library `reqif`), `.csv` with a column `id`, or `.json` of sphinx-needs.

    Raises:
        ReportError: located, if it is none of these, or two requirements have the same id.
    """
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise ReportError(f"{path}: not a list of requirements: expected {', '.join(_READERS)}")
    try:
        made = tuple(reader(path))
    except FileNotFoundError:
        raise ReportError(f"{path}: no such file") from None
    except MalformedError as error:
        raise ReportError(f"{path}{error}") from None
    seen: set[str] = set()
    for entry in made:
        if not entry.id or entry.id in seen:
            raise ReportError(
                f"{path}: {f'two requirements have the id {entry.id!r}' if entry.id else 'a requirement has no id'}"
            )
        seen.add(entry.id)
    return made


def _read_csv(path: Path) -> Iterator[ListedRequirement]:
    try:
        reader = csv.DictReader(io.StringIO(read_text(path)), strict=True)
        columns = {(name or "").strip().lower(): name for name in reader.fieldnames or ()}
        if "id" not in columns:
            raise MalformedError(f":1: no column `id`; found {', '.join(columns) or 'nothing'}")
        for row in reader:
            values = {name: (row.get(column) or "").strip() for name, column in columns.items()}
            yield ListedRequirement(**{name: values.get(name, "") for name in ("id", "title", "text", "source")})
    except csv.Error as error:
        raise MalformedError(f":{reader.line_num}: not CSV: {error}") from None


class _Need(Struct):
    title: str = ""
    content: str = ""
    source: str = ""


class _NeedsVersion(Struct):
    needs: dict[str, _Need]


class _NeedsFile(Struct):
    """The parts read from `needs.json`."""

    current_version: str
    versions: dict[str, _NeedsVersion]


def _read_needs(path: Path) -> Iterator[ListedRequirement]:
    file = from_json(read_text(path), _NeedsFile)
    if file.current_version not in file.versions:
        raise MalformedError(f": has no version {file.current_version!r}, which it names as the current one")
    for name, need in file.versions[file.current_version].needs.items():
        yield ListedRequirement(id=name, title=need.title, text=need.content, source=need.source)


_ID, _NAME, _TEXT = (
    ("ReqIF.ForeignID", "UID"),
    ("ReqIF.Name", "ReqIF.ChapterName", "TITLE"),
    ("ReqIF.Text", "STATEMENT"),
)
"""Usual names of attributes, from the ReqIF implementation guide (prostep ivip) and StrictDoc."""


_NO_REQUIREMENTS = ("SECTION", "TEXT")
"""Types of StrictDoc for headings and text between requirements."""


def _read_archive(path: Path) -> Iterator[ListedRequirement]:
    """All ReqIF files of an archive; pictures and other documents are ignored."""
    try:
        with ZipFile(io.BytesIO(read_bytes(path))) as archive:
            names = sorted(name for name in archive.namelist() if name.lower().endswith(".reqif"))
            for name in names:
                with archive.open(name) as file:
                    data = file.read(MAX_BYTES + 1)
                if len(data) > MAX_BYTES:
                    raise MalformedError(f": its file {name[:100]} is too large")
                yield from _parse_reqif(data.decode("utf-8"))
    except (BadZipFile, UnicodeDecodeError, NotImplementedError, RuntimeError, zlib.error) as error:
        raise MalformedError(f": not an archive of ReqIF: {error}") from None
    if not names:
        raise MalformedError(": this archive has no file *.reqif")


def _read_reqif(path: Path) -> Iterator[ListedRequirement]:
    return _parse_reqif(read_text(path))


def _parse_reqif(text: str) -> Iterator[ListedRequirement]:
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise MalformedError(": has a document type or entities, which no ReqIF file needs")
    try:
        from reqif.parser import ReqIFParser  # type: ignore[import-untyped,unused-ignore]
    except ImportError:
        raise MalformedError(": needs the library reqif: pip install 'pytest-hricdv[evidence]'") from None
    try:
        bundle = ReqIFParser.parse_from_string(text)
    except Exception as error:  # whatever the library raises for other files
        raise MalformedError(f": not ReqIF: {error or type(error).__name__}") from None
    content = bundle.core_content.req_if_content if bundle.core_content is not None else None
    things = list(getattr(content, "spec_objects", None) or ())
    written = len(re.findall(r"<(?:\w+:)?SPEC-OBJECT[\s>]", re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL)))
    if len(things) != written:
        raise MalformedError(f": has {written} SPEC-OBJECT, {len(things)} of them where ReqIF allows them")
    types = {kind.identifier: kind for kind in getattr(content, "spec_types", None) or ()}
    names = {name: getattr(kind, "long_name", None) for name, kind in types.items()}
    things = [thing for thing in things if names.get(thing.spec_object_type) not in _NO_REQUIREMENTS]
    values = [_attributes(thing, types.get(thing.spec_object_type)) for thing in things]
    ids = [_first(entry, _ID) or thing.identifier for entry, thing in zip(values, things, strict=True)]
    if len({*ids}) < len(ids):  # ids for people may be repeated; those of ReqIF are unique
        ids = [thing.identifier for thing in things]
    for name, entry, thing in zip(ids, values, things, strict=True):
        title = _first(entry, _NAME) or thing.long_name or ""
        yield ListedRequirement(id=name, title=title, text=_first(entry, _TEXT))


def _attributes(thing: Any, kind: Any) -> dict[str, str]:
    """Name of each attribute of a requirement -> its value without markup."""
    definitions = getattr(kind, "attribute_map", {})
    made = {}
    for attribute in thing.attributes:
        name = getattr(definitions.get(attribute.definition_ref), "long_name", None) or attribute.definition_ref
        value = attribute.value if isinstance(attribute.value, str) else " ".join(map(str, attribute.value))
        made[name] = " ".join(re.sub(r"<[^>]*>", " ", value).split())
    return made


def _first(values: Mapping[str, str], wanted: tuple[str, ...]) -> str:
    return next((values[name] for name in wanted if values.get(name)), "")


_READERS: Mapping[str, Callable[[Path], Iterator[ListedRequirement]]] = {
    ".csv": _read_csv,
    ".json": _read_needs,
    ".reqif": _read_reqif,
    ".reqifz": _read_archive,
}
