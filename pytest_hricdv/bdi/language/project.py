"""`read_project` reads Jason's project files (``.mas2j``): the agents of a system, and the files of their programs.

`MultiAgentSystem.load`, lint and test generation call it. They get a `Project` with an `AgentEntry` for each agent;
`beliefs_and_goals` gives the beliefs and goals that the project file adds to an agent.
"""

from __future__ import annotations

import os
import re
from bisect import bisect_right
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

from pytest_hricdv.bdi.language.errors import BdiSyntaxError, Location
from pytest_hricdv.bdi.language.parser import parse_program, read_source, with_encoding
from pytest_hricdv.bdi.language.syntax import Program, Rule
from pytest_hricdv.bdi.language.terms import Structure

_TOKEN = re.compile(
    r"(?P<skip>\s+|//[^\n]*|/\*.*?\*/)|(?P<string>\"[^\"\\\n]*(?:\\.[^\"\\\n]*)*\")"
    r"|(?P<word>(?:\.{0,2}/)*[A-Za-z_$][\w$]*(?:[./\\-][\w$]+)*)|(?P<number>[0-9]+(?:\.[0-9]+)?)"
    r"|(?P<sign>[{}()\[\]:;,=#])",
    re.DOTALL,
)
_SECTIONS = frozenset(
    {"infrastructure", "environment", "executionControl", "agents", "classpath", "aslSourcePath", "directives"}
)
MAX_AGENTS = 10_000
"""Most agents of a project, including copies: this many load in a second; `#99999999` would exhaust memory."""
MAX_FOLDERS = 100
"""Most folders of a project: the source of each agent is searched for in all of them."""
_AGENT_EXTRAS = frozenset({"agentArchClass", "agentClass", "beliefBaseClass", "at"})
_SUPPORTED_OPTIONS = {"beliefs", "goals", "verbose"}
_DEFAULTS_OF_OPTIONS = {"events": "discard", "intBels": "sameFocus", "synchronised": "false", "nrcbp": "1"}
"""Options of Jason that have no effect here, with the values that need no warning."""


@dataclass(frozen=True, slots=True)
class AgentEntry:
    """An agent of a project.

    Args:
        name: its name, unique in the project.
        source: its AgentSpeak file.
        location: where the project names it.
        beliefs: beliefs from the option ``beliefs``, as AgentSpeak text.
        goals: goals from the option ``goals``, as AgentSpeak text.
    """

    name: str
    source: Path
    location: Location
    beliefs: str = ""
    goals: str = ""


@dataclass(frozen=True, slots=True)
class Project:
    """A multi-agent system.

    Args:
        agents: its agents, in the order of their cycles.
        text: the text of the project file.
        warnings: what in it has no effect here, each once, with its place.
        environment: the Java class that it names as its environment, or empty.
    """

    name: str
    agents: tuple[AgentEntry, ...]
    text: str
    warnings: tuple[str, ...] = ()
    environment: str = ""


def read_project(path: Path) -> Project:
    """Read a project file.

    Raises:
        FileNotFoundError: there is no such file.
        BdiError: it cannot be read, is not a project, or has no agents.
    """
    source = read_source(path)
    try:
        project = _ProjectReader(source.text, str(path)).project()
    except BdiSyntaxError as error:
        raise with_encoding(error, source) from None
    if source.not_utf8:
        project = replace(project, warnings=(f"{source.not_utf8}: read as Latin-1", *project.warnings))
    return project


def beliefs_and_goals(entry: AgentEntry) -> tuple[tuple[Structure | Rule, ...], tuple[Structure, ...]]:
    """The beliefs and the goals that an agent's options give, in the order written.

    Raises:
        BdiSyntaxError: an option is not a list of beliefs or goals.
    """
    where = f"{entry.location}: option"
    return _read(f"{where} beliefs", entry.beliefs, "").beliefs, _read(f"{where} goals", entry.goals, "!").goals


@lru_cache(maxsize=64)  # copies of an agent have the same options
def _read(where: str, text: str, sign: str) -> Program:
    source = " ".join(f"{sign}{part}." for part in _parts(text.strip().removesuffix(".")))
    return parse_program(source, where)


def _parts(text: str) -> list[str]:
    """The parts between the commas that are outside brackets and strings."""
    commas, depth, quoted = [-1], 0, False  # the first part begins after an imagined comma
    for place, character in enumerate(text):
        quoted ^= character == '"'
        depth += 0 if quoted else (character in "([") - (character in ")]")
        if character == "," and not depth and not quoted:
            commas.append(place)
    parts = (text[comma + 1 : end].strip() for comma, end in pairwise([*commas, len(text)]))
    return [part for part in parts if part]


@dataclass(frozen=True, slots=True)
class _Token:
    kind: str
    text: str
    position: int


class _ProjectReader:
    """A recursive descent parser of a project text. Settings of Jason's Java side are skipped."""

    def __init__(self, text: str, file: str) -> None:
        self._text = text
        self._file = file
        self._line_starts = [0, *(end.end() for end in re.finditer("\n", text))]
        self._tokens = list(self._scan())
        self._next = 0
        self._source_paths = [Path()]
        self._warnings: dict[str, str] = {}
        self._environment = ""

    def project(self) -> Project:
        self._expect("MAS")
        name = self._take("word", "a name").text
        self._expect("{")
        entries: list[AgentEntry] = []
        seen_agents: _Token | None = None
        while not self._at("}"):
            section = self._take("word", "a section such as 'agents'")
            if section.text not in _SECTIONS:
                raise self._error(f"expected one of {', '.join(sorted(_SECTIONS))}, found '{section.text}'", section)
            self._expect(":")
            if section.text == "agents":
                seen_agents = section
                while self._in_section():
                    entries += self._agent(len(entries))
                    if len(entries) > MAX_AGENTS:
                        raise self._error(f"expected at most {MAX_AGENTS:,} agents", self._peek())
            else:
                self._other_section(section)
        self._expect("}")
        if self._peek().kind != "end":
            raise self._error_unexpected("the end of the file")
        if not entries:
            raise self._error("a project needs agents", seen_agents or self._tokens[0])
        warnings = tuple(self._warnings.values())
        return Project(name, self._at_entry(entries), self._text, warnings, self._environment)

    def _other_section(self, section: _Token) -> None:
        """A section other than ``agents``: of these, only the source path and the environment are used."""
        first = self._peek().text
        strings = self._section_strings()
        if section.text == "aslSourcePath":
            if len(strings) > MAX_FOLDERS:
                raise self._error(f"expected at most {MAX_FOLDERS} folders, found {len(strings)}", section)
            self._source_paths = [Path(part.replace("\\", "/")) for part in strings]
        elif section.text == "environment":
            self._environment = first
        elif section.text == "infrastructure":
            if first != "Centralised":
                self._ignore(section, f"infrastructure {first}: agents always run in one process, in turn")
        elif section.text != "classpath":
            self._ignore(section, f"section {section.text}")

    def _ignore(self, token: _Token, ignored: str) -> None:
        """Warn once that something has no effect."""
        self._warnings.setdefault(ignored, f"{self._place(token)}: ignored: {ignored}")

    def _agent(self, before: int) -> list[AgentEntry]:
        token = self._advance() if self._peek().kind == "string" else self._take("word", "an agent's name")
        name, count = token.text.strip('"'), 1
        source = f"{name}.asl"
        if self._peek().kind in ("word", "string") and self._peek().text not in _AGENT_EXTRAS:
            source = self._advance().text.strip('"').replace("\\", "/")
            source += "" if Path(source).suffix else ".asl"
        options: dict[str, str] = {}
        while not self._at(";"):
            if self._at("["):
                options = self._options()
            elif self._at("#"):
                self._advance()
                count = self._count(before)
            elif self._peek().text in _AGENT_EXTRAS:
                extra = self._advance()
                self._ignore(extra, f"{extra.text} of agents")
                self._skip_value()
            else:
                raise self._error_unexpected("';'")
        self._expect(";")
        names = [name] if count == 1 else [f"{name}{number}" for number in range(1, count + 1)]
        place = self._place(token)
        beliefs, goals = options.get("beliefs", ""), options.get("goals", "")
        return [AgentEntry(agent_name, Path(source), place, beliefs, goals) for agent_name in names]

    def _count(self, before: int) -> int:
        token = self._take("number", "the number of agents")
        digits = token.text.lstrip("0") or "0"
        # int() itself refuses texts of more than 4,300 digits, without a place in the file.
        if not digits.isdigit() or len(digits) > 9 or not 1 <= int(digits) <= MAX_AGENTS - before:
            most = f"{MAX_AGENTS:,}" if not before else f"{MAX_AGENTS - before:,} more, {MAX_AGENTS:,} together"
            raise self._error(f"expected a whole number of agents from 1 to {most}, found '{token.text[:20]}'", token)
        return int(digits)

    def _options(self) -> dict[str, str]:
        options: dict[str, str] = {}
        self._expect("[")
        while True:
            option = self._take("word", "an option's name")
            name = option.text
            self._expect("=")
            value = self._advance()
            if value.kind not in ("string", "word", "number"):
                raise self._error_unexpected("an option's value", value)
            options[name] = value.text[1:-1].replace('\\"', '"') if value.kind == "string" else value.text
            if name not in _SUPPORTED_OPTIONS and options[name] != _DEFAULTS_OF_OPTIONS.get(name):
                self._ignore(option, f"option {name} of agents")
            if not self._at(","):
                self._expect("]")
                return options
            self._advance()

    def _skip_value(self) -> None:
        """Skip a Java class with its arguments, or a host name."""
        self._advance()
        if self._at("("):
            while not self._at(")"):
                if self._advance().kind == "end":
                    raise self._error_unexpected("')'")
            self._advance()

    def _section_strings(self) -> list[str]:
        """The strings of a section that ends where the next section or the project does."""
        strings: list[str] = []
        while self._in_section():
            token = self._advance()
            if token.kind == "end":
                raise self._error_unexpected("'}'", token)
            if token.kind == "string":
                strings.append(token.text[1:-1])
        return strings

    def _in_section(self) -> bool:
        """Whether neither the next section nor the end of the project follows."""
        following = self._tokens[min(self._next + 1, len(self._tokens) - 1)]
        starts_section = self._peek().text in _SECTIONS and following.text == ":"
        return not starts_section and not self._at("}")

    def _at_entry(self, entries: Iterable[AgentEntry]) -> tuple[AgentEntry, ...]:
        """The entries, each of another name, with their sources searched for in the folders of the source path."""
        # As in Jason, also next to the project file: many projects name a folder that is missing.
        folders = [Path(self._file).parent / folder for folder in dict.fromkeys([*self._source_paths, Path()])]
        agents: dict[str, AgentEntry] = {}
        for entry in entries:
            if entry.name in agents:
                raise BdiSyntaxError.at(f"a second agent named {entry.name}", entry.location, self._text)
            candidates = [folder / entry.source for folder in folders]
            source = next((candidate for candidate in candidates if os.path.exists(candidate)), candidates[0])
            agents[entry.name] = replace(entry, source=source)
        return tuple(agents.values())

    # --- tokens

    def _scan(self) -> list[_Token]:
        tokens: list[_Token] = []
        position = 0
        while position < len(self._text):
            match = _TOKEN.match(self._text, position)
            if match is None:
                bad = _Token("bad", self._text[position], position)
                raise self._error(f"unexpected character {bad.text!r}", bad)
            if match.lastgroup != "skip":
                tokens.append(_Token(match.lastgroup or "", match[0], position))
            position = match.end()
        return [*tokens, _Token("end", "", len(self._text.rstrip()))]

    def _peek(self) -> _Token:
        return self._tokens[self._next]

    def _advance(self) -> _Token:
        token = self._tokens[self._next]
        # The last token, the end, is never passed: whoever reads on sees the end again, and reports it.
        self._next = min(self._next + 1, len(self._tokens) - 1)
        return token

    def _at(self, text: str) -> bool:
        return self._peek().text == text

    def _expect(self, text: str) -> None:
        if not self._at(text):
            raise self._error_unexpected(f"'{text}'")
        self._advance()

    def _take(self, kind: str, expected: str) -> _Token:
        if self._peek().kind != kind:
            raise self._error_unexpected(expected)
        return self._advance()

    def _error_unexpected(self, expected: str, token: _Token | None = None) -> BdiSyntaxError:
        token = token or self._peek()
        actual = "the end of the file" if token.kind == "end" else f"'{token.text}'"
        return self._error(f"expected {expected}, found {actual}", token)

    def _place(self, token: _Token) -> Location:
        line = bisect_right(self._line_starts, token.position)
        return Location(self._file, line, token.position - self._line_starts[line - 1] + 1)

    def _error(self, message: str, token: _Token) -> BdiSyntaxError:
        return BdiSyntaxError.at(message, self._place(token), self._text)
