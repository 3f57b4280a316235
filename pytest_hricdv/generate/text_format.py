"""The text format of abstract tests: reading and writing (for the format see `abstract`)."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field

from pytest_hricdv.generate.abstract import AbstractTest, canonical_command
from pytest_hricdv.generate.error import GenerateError
from pytest_hricdv.generate.ids import Draft, identify, slug
from pytest_hricdv.suggestion import nearest

_HEADER = re.compile(r"#\s*(id|suite|aim|beliefs|seed|name|plans \S+)\s*:(.*)\Z")


@dataclass
class _Block:
    """The lines between two blank lines: a test, or comments only."""

    where: str = ""
    headers: dict[str, str] = field(default_factory=dict)
    commands: list[str] = field(default_factory=list)

    @property
    def is_test(self) -> bool:
        """Commands make a test; so does an id alone, as a test may have no action."""
        return bool(self.commands) or "id" in self.headers


def dump_tests(tests: Iterable[AbstractTest]) -> str:
    """The tests as text that `parse_tests` reads back unchanged."""
    return "\n".join(_dump(test) for test in tests)


def _dump(test: AbstractTest) -> str:
    headers = [f"# id: {test.id}", f"# suite: {test.suite}", f"# aim: {test.target}", f"# seed: {test.seed}"]
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

    A test that states an id keeps it; others get id and seed from their content.

    Args:
        text: the text.
        file: name of the text in errors.
        suite: the suite of tests that state none.
        master_seed: for the seeds of tests that state none.
        known: the commands that can be executed; if any are given, others are errors.

    Raises:
        GenerateError: a malformed or unknown command or a malformed header, with file, line and column.
    """
    blocks = [block for block in _blocks(text, file, known) if block.is_test]
    complete = [_complete_test(block) if "id" in block.headers else None for block in blocks]
    _check_ids(blocks)
    drafts: dict[str, list[Draft]] = {}
    for block, test in zip(blocks, complete, strict=True):
        if test is None:
            drafts.setdefault(block.headers.get("suite", suite), []).append(_draft(block))
    identified = {name: iter(identify(name, master_seed, listed)) for name, listed in drafts.items()}
    return tuple(
        test if test is not None else next(identified[block.headers.get("suite", suite)])
        for block, test in zip(blocks, complete, strict=True)
    )


def _check_ids(blocks: Iterable[_Block]) -> None:
    places: dict[str, str] = {}
    for block in blocks:
        name = block.headers.get("id")
        if name is not None and name in places:
            raise GenerateError(
                f"{block.where}: a second test with the id {name!r}, which is at {places[name]} already; expected "
                "each id once: without its '# id:' line a test gets a new one"
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
        command = canonical_command(text)
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
    target = headers.get("aim") or (slug(name)[:40].rstrip("-") if name else target_of_commands(block.commands))
    return Draft(target, tuple(headers.get("beliefs", "").split()), tuple(block.commands), _plans(block), name)


def target_of_commands(commands: Collection[str]) -> str:
    """The target of a test that came from no beliefs: its number of actions."""
    return f"{len(commands)}-actions"


def _complete_test(block: _Block) -> AbstractTest:
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
            target=draft.target,
            beliefs=draft.beliefs,
            lines=draft.lines,
            plans=draft.plans,
            seed=int(block.headers["seed"]),
            name=draft.name,
        )
    except GenerateError as error:
        raise GenerateError(f"{block.where}: {error}") from None
