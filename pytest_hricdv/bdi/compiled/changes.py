"""Changes of a compiled agent's beliefs."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from pytest_hricdv.bdi.language.terms import Key, Structure, sorted_terms

from .activity import Args
from .program import Annots, Slot, Store, TriggerCode

if TYPE_CHECKING:
    from .agent import CompiledAgent

_SOURCE: Key = (False, "source", 1)


def add(agent: CompiledAgent, store: Store, slot: Slot, annots: Annots) -> Annots | None:
    """Add a belief, or its annotations to the belief already held; those that are new, None if none is."""
    held = store.get(slot)
    if held is None:
        store[slot] = annots
    else:
        added = tuple(annot for annot in annots if annot not in held)
        if not added:
            return None
        store[slot] = sorted_terms(held + added)
        annots = added
    agent.run.progress += 1
    return annots


def remove(agent: CompiledAgent, store: Store, slot: Slot, annots: Annots) -> Annots | None:
    """Remove a belief's annotations, and the belief with its last source; None if that changes nothing."""
    held = store.get(slot)
    if held is None:
        return None
    if held is not annots and held != annots:
        if not all(annot in held for annot in annots):
            return None
        left = tuple(annot for annot in held if annot not in annots)
        if any(isinstance(annot, Structure) and annot.key == _SOURCE for annot in left):
            store[slot] = left
            agent.run.progress += 1
            return annots
    del store[slot]
    agent.run.progress += 1
    return annots


def displace(agent: CompiledAgent, store: Store, slot: Slot | None, annots: Annots, trigger: TriggerCode) -> bool:
    """Remove the newest belief of a store, or the one of a slot, that has these annotations.

    Returns:
        Whether there may be a plan for that.
    """
    for candidate in reversed(store) if slot is None else (slot,):
        held = store.get(candidate)
        if held is not None and (held is annots or all(annot in held for annot in annots)):
            remove(agent, store, candidate, annots)
            return _lost(agent, trigger, () if candidate is slot else candidate, annots)
    return False


def replace(agent: CompiledAgent, table: Store, args: Args, annots: Annots) -> Annots | None:
    """As :func:`displace` and then :func:`add`, where no plan is for what is displaced."""
    if len(table) == 1:
        # Most often the one belief of a predicate that has a single value, with the same source.
        for held in table.values():
            if held is annots or held == annots:
                table.clear()
                table[args] = annots
                agent.run.progress += 1
                return annots
    for candidate in reversed(table):
        held = table[candidate]
        if all(annot in held for annot in annots):
            remove(agent, table, candidate, annots)
            break
    return add(agent, table, args, annots)


def abolish(agent: CompiledAgent, store: Store, slots: Iterable[Slot], trigger: TriggerCode) -> bool:
    """Remove beliefs with all their sources; whether there may be a plan for that."""
    event = False
    for slot in slots:
        held = store.pop(slot, None)
        if held is not None:
            agent.run.progress += 1
            event |= _lost(agent, trigger, slot if isinstance(slot, tuple) else (), held)
    return event


def _lost(agent: CompiledAgent, trigger: TriggerCode, args: Args, annots: Annots) -> bool:
    if trigger.select is None:
        return False
    agent.events.append(((trigger, args, annots), None))
    return True
