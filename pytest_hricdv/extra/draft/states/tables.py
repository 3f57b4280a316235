"""State machines as tables: what follows what, and functions by the names of states."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from pytest_hricdv.extra.draft.found.findings import Machine, Place, State, Transition
from pytest_hricdv.extra.draft.reading.constants import Member, Reference, UnknownValueError, evaluate
from pytest_hricdv.extra.draft.reading.sources import Module, Sources
from pytest_hricdv.extra.draft.reading.value_flow import ValueFlow
from pytest_hricdv.extra.draft.states.holders import state_name

TRANSITIONS = re.compile(r"transition|next|allowed|follow|edges|successor|moves", re.IGNORECASE)
"""Names of tables whose values are states, where their shape alone does not say so."""

FUNCTIONS = re.compile(r"state|handler|action|step|phase|mode", re.IGNORECASE)
"""Names of tables of functions that are states."""

MIN_STATES = 2


@dataclass(frozen=True)
class Row:
    """One line of a table of transitions."""

    source: str
    target: str
    event: str


@dataclass(frozen=True)
class Table:
    """A constant of a module or class that is a table."""

    name: str
    content: Any
    place: Place
    module: Module
    node: ast.expr


def table_machines(sources: Sources, flow: ValueFlow) -> Iterator[Machine]:
    """Machines whose transitions stand in a table, with the states that have functions, where there is such a table."""
    tables = list(_tables(sources))
    functions = [table for table in tables if _is_of_functions(table)]
    told: set[str] = set()
    for table in tables:
        rows = _rows(table)
        if not rows:
            continue
        of_states = _matching(functions, {row.source for row in rows})
        names = (
            list(of_states.content)
            if of_states is not None
            else [name for row in rows for name in (row.source, row.target)]
        )
        states = {state_name(name): (of_states or table).place for name in names}
        told |= set(states)
        moves = [row for row in rows if row.source in states and row.target in states]
        yield _machine(table, states, moves)
    for table in functions:
        names = [state_name(name) for name in table.content]
        if not set(names) & told:
            moves = _returned(table, flow, set(names))
            if moves or re.search("state", table.name, re.IGNORECASE):
                yield _machine(table, dict.fromkeys(names, table.place), moves)


def _machine(table: Table, states: dict[str, Place], rows: list[Row]) -> Machine:
    places = _key_places(table)
    listed = tuple(State(name, places.get(name, place)) for name, place in states.items())
    unique = {(row.source, row.target): row for row in reversed(rows)}
    moves = tuple(
        Transition(row.source, row.target, places.get(row.source, table.place), row.event)
        for row in reversed(list(unique.values()))
    )
    return Machine(table.name, "table", listed, moves, table.place)


def _key_places(table: Table) -> dict[str, Place]:
    """Where the lines of a table are, by the text that they begin with."""
    places: dict[str, Place] = {}
    for node in ast.walk(table.node):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            places.setdefault(node.value, table.module.place(node))
    return places


def _tables(sources: Sources) -> Iterator[Table]:
    for module in sources.modules:
        bodies = [module.tree.body, *(node.body for node in ast.walk(module.tree) if isinstance(node, ast.ClassDef))]
        for body in bodies:
            for statement in body:
                if not isinstance(statement, ast.Assign | ast.AnnAssign) or statement.value is None:
                    continue
                target = statement.targets[0] if isinstance(statement, ast.Assign) else statement.target
                if not isinstance(target, ast.Name):
                    continue
                try:
                    content = evaluate(sources, module, statement.value)
                except UnknownValueError:
                    continue
                if isinstance(content, dict | tuple) and content:
                    yield Table(target.id, content, module.place(statement), module, statement.value)


def _is_of_functions(table: Table) -> bool:
    content = table.content
    return (
        isinstance(content, dict)
        and len(content) >= MIN_STATES
        and all(state_name(key) for key in content)
        and all(
            isinstance(value, Reference) and value.name and not value.name.endswith("()") for value in content.values()
        )
        and FUNCTIONS.search(table.name) is not None
    )


def _matching(functions: list[Table], sources: set[str]) -> Table | None:
    for table in functions:
        if sources <= {state_name(key) for key in table.content}:
            return table
    return None


def _rows(table: Table) -> list[Row]:
    """The lines of a table of transitions; none where it is no such table."""
    content, is_named = table.content, TRANSITIONS.search(table.name) is not None
    if isinstance(content, dict):
        rows = _rows_of_dict(content, is_named)
    elif is_named and all(isinstance(row, tuple) and len(row) in (2, 3) for row in content):
        rows = _rows_of_list(content)
    else:
        rows = []
    return rows if len({row.source for row in rows}) >= MIN_STATES else []


def _rows_of_dict(content: dict[Any, Any], is_named: bool) -> list[Row]:
    rows: list[Row] = []
    keys = {state_name(key) for key in content} - {""}
    of_one_enum = _one_enum(content)
    for key, value in content.items():
        if isinstance(key, tuple) and len(key) == 2 and state_name(key[0]):
            target = value[0] if isinstance(value, tuple) and value else value
            rows.append(Row(state_name(key[0]), state_name(target), state_name(key[1])))
        elif state_name(key) and isinstance(value, dict):
            rows += [Row(state_name(key), state_name(target), state_name(event)) for event, target in value.items()]
        elif state_name(key) and isinstance(value, tuple) and (is_named or of_one_enum):
            rows += [Row(state_name(key), state_name(target), "") for target in value]
        elif state_name(key) and state_name(value) and (is_named or of_one_enum):
            rows.append(Row(state_name(key), state_name(value), ""))
        elif not (isinstance(value, tuple) and not value):
            return []
    is_tuple_keyed = all(isinstance(key, tuple) for key in content)
    sources = {row.source for row in rows} | keys
    targets = {row.target for row in rows}
    if "" in targets or not targets or len(targets & sources) * 2 < len(targets):
        return []
    return rows if is_tuple_keyed or is_named or targets <= sources else []


def _one_enum(content: dict[Any, Any]) -> bool:
    parts = [
        part for key, value in content.items() for part in (key, *(value if isinstance(value, tuple) else (value,)))
    ]
    return all(isinstance(part, Member) for part in parts) and len({part.enum for part in parts}) == 1


def _rows_of_list(content: tuple[Any, ...]) -> list[Row]:
    """Lines (source, target), (source, event, target) or (event, source, target): by equal names."""
    if any(not state_name(part) for row in content for part in row):
        return []
    columns = [[state_name(part) for part in column] for column in zip(*content, strict=False)]
    if len(columns) == 2:
        return [Row(source, target, "") for source, target in zip(*columns, strict=True)]
    first = len(set(columns[0]) & set(columns[2]))
    second = len(set(columns[1]) & set(columns[2]))
    early = len(set(columns[0]) & set(columns[1]))
    order = (0, 1, 2) if early > max(first, second) else (0, 2, 1) if first >= second else (1, 2, 0)
    return [Row(*(columns[index][line] for index in order)) for line in range(len(content))]


def _returned(table: Table, flow: ValueFlow, names: set[str]) -> list[Row]:
    """Transitions of functions that return the name of the next state."""
    rows = []
    for key, value in table.content.items():
        for scope in flow.methods.get(value.name.rpartition(".")[2], ())[:1]:
            for node in ast.walk(scope.node):
                if isinstance(node, ast.Return) and node.value is not None:
                    targets = map(state_name, flow.constants(node.value, scope.module, scope))
                    rows += [Row(state_name(key), target, "") for target in targets if target in names]
    return rows
