"""Files of abstract tests: reading and writing the text format (see `abstract`)."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field

from .abstract import AbstractTest, command_of
from .error import GenerateError, nearest
from .identity import Draft, identify, slug

_HEADER = re.compile(r"#\s*(id|suite|aim|beliefs|seed|name|plans \S+)\s*:(.*)\Z")


@dataclass
class _Block:
    """The lines between two blank ones: a test, or plain commentary."""

    where: str = ""
    headers: dict[str, str] = field(default_factory=dict)
    commands: list[str] = field(default_factory=list)

    @property
    def is_test(self) -> bool:
        """Commands make a test; so does an id alone, for there is a test in which the human does nothing."""
        return bool(self.commands) or "id" in self.headers


def dump_tests(tests: Iterable[AbstractTest]) -> str:
    """The tests as text that `parse_tests` reads back unchanged."""
    return "\n".join(_dump(test) for test in tests)


def _dump(test: AbstractTest) -> str:
    headers = [f"# id: {test.id}", f"# suite: {test.suite}", f"# aim: {test.aim}", f"# seed: {test.seed}"]
    if test.beliefs:
        headers.append(f"# beliefs: {' '.join(test.beliefs)}")
    if test.name:
        headers.append(f"# name: {test.name}")
    headers += [f"# plans {agent}: {' '.join(labels)}".rstrip() for agent, labels in sorted(test.plans.items())]
    return "\n".join([*headers, *test.lines]) + "\n"


def parse_tests(
    text: str, *, file: str, suite: str, master_seed: int = 0, known: Collection[str] = ()
) -> tuple[AbstractTest, ...]:
    """The tests of a text.

    A test with an id is taken at its word; one without gets its id and seed from its content.

    Args:
        text: the text.
        file: what to call the text in errors.
        suite: the suite of tests that name none.
        master_seed: the seed from which tests without one get theirs.
        known: the commands that can be enacted; if any are given, others are errors.

    Raises:
        GenerateError: a malformed or unknown command or a malformed header, with file, line and column.
    """
    blocks = [block for block in _blocks(text, file, known) if block.is_test]
    finished = [_stated(block) if "id" in block.headers else None for block in blocks]
    _check_ids(blocks)
    drafts: dict[str, list[Draft]] = {}
    for block, test in zip(blocks, finished, strict=True):
        if test is None:
            drafts.setdefault(block.headers.get("suite", suite), []).append(_draft(block))
    fresh = {name: iter(identify(name, master_seed, listed)) for name, listed in drafts.items()}
    return tuple(
        test if test is not None else next(fresh[block.headers.get("suite", suite)])
        for block, test in zip(blocks, finished, strict=True)
    )


def _check_ids(blocks: Iterable[_Block]) -> None:
    places: dict[str, str] = {}
    for block in blocks:
        name = block.headers.get("id")
        if name is not None and name in places:
            raise GenerateError(
                f"{block.where}: a second test with the id {name!r}, which is at {places[name]} already; expected "
                "each id once: without its '# id:' line a test gets one of its own"
            )
        places |= {} if name is None else {name: block.where}


def _blocks(text: str, file: str, known: Collection[str]) -> list[_Block]:
    blocks = [_Block()]
    for number, line in enumerate(text.splitlines(), 1):
        where = f"{file}:{number}:{len(line) - len(line.lstrip()) + 1}"
        stripped = line.strip()
        if not stripped:
            blocks.append(_Block())
        elif stripped.startswith("#"):
            _read_comment(blocks[-1], stripped, where)
        else:
            blocks[-1].where = blocks[-1].where or where
            blocks[-1].commands.append(_read_command(stripped.partition("#")[0], where, known))
    return blocks


def _read_comment(block: _Block, comment: str, where: str) -> None:
    match = _HEADER.match(comment)
    if match is None:
        return
    key, value = match[1], " ".join(match[2].split())
    if key in block.headers:
        raise GenerateError(f"{where}: a second '# {key}:' in one test; expected a blank line between tests")
    if key == "seed" and not (value.isascii() and value.isdigit()):
        raise GenerateError(f"{where}: seed {value!r}: expected a whole number, at least 0")
    block.where = block.where or where
    block.headers[key] = value


def _read_command(text: str, where: str, known: Collection[str]) -> str:
    try:
        command = command_of(text)
    except GenerateError as error:
        raise GenerateError(f"{where}: {error}{nearest(text.strip(), known)}") from None
    if known and command not in known:
        raise GenerateError(f"{where}: unknown command {command!r}{nearest(command, known)}")
    return command


def _plans(block: _Block) -> dict[str, tuple[str, ...]]:
    return {key.split()[1]: tuple(value.split()) for key, value in block.headers.items() if key.startswith("plans ")}


def _draft(block: _Block) -> Draft:
    headers = block.headers
    name = headers.get("name", "")
    aim = headers.get("aim") or (slug(name)[:40].rstrip("-") if name else actions_aim(block.commands))
    return Draft(aim, tuple(headers.get("beliefs", "").split()), tuple(block.commands), _plans(block), name)


def actions_aim(commands: Collection[str]) -> str:
    """The aim of a test that came from no beliefs: how many actions it has."""
    return f"{len(commands)}-actions"


def _stated(block: _Block) -> AbstractTest:
    missing = [key for key in ("suite", "aim", "seed") if key not in block.headers]
    if missing:
        raise GenerateError(
            f"{block.where}: test {block.headers['id']!r} has an id but no {missing[0]}; "
            f"expected '# {missing[0]}: ...' beside it, or no id at all"
        )
    draft = _draft(block)
    try:
        return AbstractTest(
            id=block.headers["id"],
            suite=block.headers["suite"],
            aim=draft.aim,
            beliefs=draft.beliefs,
            lines=draft.lines,
            plans=draft.plans,
            seed=int(block.headers["seed"]),
            name=draft.name,
        )
    except GenerateError as error:
        raise GenerateError(f"{block.where}: {error}") from None
