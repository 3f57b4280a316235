"""Deciding whether an agent is compiled, and compiling its program."""

from __future__ import annotations

from pytest_hricdv.bdi.language.syntax import Rule
from pytest_hricdv.bdi.language.terms import SOURCE_PERCEPT, Structure

from ..beliefs import BeliefBase
from ..company import Company
from ..library import KQML_RECEIVED, PlanLibrary
from . import changes, effects, posting
from .calm import CalmAnalysis
from .code import AgentCode
from .program import PlanCode, ProgramCode
from .runtime import NAMES
from .selection import SelectionWriter
from .writer import Names

_CHANGES: dict[str, object] = {
    "abolish": changes.abolish,
    "act": effects.act,
    "add": changes.add,
    "displace": changes.displace,
    "enter": effects.enter,
    "filled": posting.filled,
    "finish": effects.finish,
    "finish_acted": effects.finish_acted,
    "hold": posting.hold,
    "lettered": posting.lettered,
    "note": effects.note,
    "note_action": effects.note_action,
    "pause": effects.pause,
    "pause_at": effects.pause_at,
    "pause_for": effects.pause_for,
    "post": posting.post,
    "post_on": posting.post_on,
    "pursue": effects.pursue,
    "remove": changes.remove,
    "replace": changes.replace,
    "spin": effects.spin,
    "wait": effects.wait,
}
"""What generated code does to its agent."""


def compile_agent(
    name: str,
    program: ProgramCode | None,
    beliefs: BeliefBase,
    library: PlanLibrary,
    events: list[tuple[str, Structure]],
) -> AgentCode | None:
    """The compiled form of an agent; None if it has to be interpreted from the start.

    Args:
        name: its name.
        program: the compiled form of its plans, if there is one.
        beliefs: what it believes at first.
        library: its plans.
        events: what it has to react to at first.
    """
    if program is None or not all(literal.ground for _, literal in events):
        return None
    if any(isinstance(belief, Rule) or SOURCE_PERCEPT in belief.annots for belief in beliefs):
        return None
    return AgentCode(name, program, beliefs, library, events)


def compile_program(library: PlanLibrary, company: Company) -> ProgramCode | None:
    """The compiled form of an agent's plans; None if none has any.

    Args:
        library: the plans.
        company: the agents of its system.
    """
    plans = [plan for plan in library.plans if not plan.builtin]
    keys = list(dict.fromkeys(plan.trigger.key for plan in plans))
    if None in keys or any(key is not None and key[1] == KQML_RECEIVED for key in keys):
        return None
    program = ProgramCode(frozenset(key for key in keys if key is not None))
    names = Names()
    forgotten = frozenset(plan.label for plan in plans if library.forgets(plan))
    selection = SelectionWriter(program, names, company.names, forgotten)
    program.selects.update((key, f"select{place}") for place, key in enumerate(keys) if key is not None)
    for key, name in program.selects.items():
        selection.write(name, key, library.relevant(*key))
    program.source = "\n".join(selection.functions)
    # One by one: a copy of a dictionary made by native code is one that Python does not specialize its look-ups for.
    namespace = {name: named for known in (NAMES, _CHANGES, names.objects) for name, named in known.items()}
    exec(compile(program.source, "<compiled AgentSpeak>", "exec"), namespace)
    for key, name in program.selects.items():
        trigger = program.trigger(*key)
        trigger.select = namespace[name]  # type: ignore[assignment]
        if trigger.sign == "+":
            program.noticed[trigger.key] = trigger
    for key, calm in CalmAnalysis(library, company).calm().items():
        program.trigger(*key).calm = calm
    for name, code in selection.plans.items():
        assert isinstance(code, PlanCode)
        code.run = namespace[name]  # type: ignore[assignment]
    return program if selection.plans else None
