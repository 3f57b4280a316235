"""What to write instead of an internal action that there is not: by what it does, where that is known."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

_SOURCE = 'agents begin with what a source says: .create_agent(name, "source.asl"), and tell it what it is to know'
_DIRECTORY = "there is no directory: agents tell each other what they offer, as in .broadcast(tell, offers(S))"

_INSTEAD = {
    ".assert": "beliefs are added with +b",
    ".asserta": "beliefs are added with +b",
    ".retract": "beliefs are deleted with -b, all of a kind with .abolish",
    ".clone": _SOURCE,
    ".save_agent": "what an agent believes is printed with .findall and .print",
    ".copy": "terms do not change: use the variable; with new variables, .copy_term",
    ".df_deregister": _DIRECTORY,
    ".df_register": _DIRECTORY,
    ".df_search": _DIRECTORY,
    ".df_subscribe": _DIRECTORY,
    ".foreach": "use for (condition) { ... }, or .foreach(condition, { ... })",
    ".forall": "use for (condition) { ... }",
    ".if_then_else": "use if (condition) { ... } else { ... }, or .if_then_else(condition, { ... }, { ... })",
    ".if": "use if (condition) { ... } else { ... }",
    ".while": "use while (condition) { ... }",
    ".for": "use for (condition) { ... }",
    ".loop": "use while (condition) { ... }, or .loop(condition, { ... })",
    ".include": 'use the directive { include("file.asl") }',
    ".intention": "use .intend(goal), or .current_intention(I) for its own plans",
    ".list_plans": "use .relevant_plans({+!_}, Plans) and .print(Plans)",
    ".list_rules": "rules are in the source only",
    ".relevant_rules": "rules are in the source only",
    ".println_error": "use .print",
    ".sleep": "use .wait(milliseconds)",
    ".stop": "use .stopMAS",
    ".exit": "use .stopMAS",
    ".append": "lists and strings are joined with .concat",
    ".size": "use .length",
    ".setof_count": "use .count",
    ".not": "negation is written not condition",
    ".to_string": "use .term2string",
    ".get_time": "use .time(H, M, S) or system.time",
    ".average": "use math.average",
    "math.mean": "use math.average",
    "math.power": "powers are written X ** Y",
    "math.pow": "powers are written X ** Y",
    "math.mod": "the remainder is written X mod Y",
}
"""What there is instead, by the name of what there is not."""

_OWN_PACKAGES = ("math.", "system.")
"""Functions here, under the names that Jason gives them; everything else with a name before the dot is a Java class."""

_NAMES_OF_JASON = """
asserta assertz clone df_deregister df_register df_search df_subscribe done drop_future_intention fork get_src_info
include intention join list_files list_plans list_rules namespace namespace_get_prop namespace_set_prop nano_time
print_unifier printf relevant_plan relevant_rules remove_source_annot rename_apart save_agent save_stats
set_random_seed type version
"""
_OF_JASON = {"math.mean", *(f".{name}" for name in _NAMES_OF_JASON.split())}
"""What Jason 1.4.2 or 3.3, or a library of its authors, has: no slip of a model that calls it."""

_LEAST_LIKENESS = 0.5
"""Below difflib's own 0.6 (chosen): for a name that is wrong for certain, a far guess beats the whole list."""


def is_foreign(name: str) -> bool:
    """Whether an action or function that there is none of here is one elsewhere: in Java, or in Jason itself.

    A model that calls it is a good one elsewhere. Other names are slips.
    """
    return not name.startswith((".", *_OWN_PACKAGES)) or name in _OF_JASON


def unknown_action(name: str, names: Iterable[str]) -> str:
    """The message for an internal action or function that there is not: what it is, and what to write instead.

    Args:
        name: as the model writes it.
        names: those that there are.
    """
    if name in _INSTEAD:
        return f"unknown internal action {name}; {_INSTEAD[name]}"
    if not name.startswith((".", *_OWN_PACKAGES)):
        action = name.replace(".", "_")
        return (
            f"{name} is an internal action in Java, of which there are none here; write a rule, or an external action "
            f"{action}(...) of a Python environment, which answers with a percept"
        )
    ordered = sorted(names)
    near = difflib.get_close_matches(name, ordered, n=3, cutoff=_LEAST_LIKENESS)
    hint = f"did you mean {' or '.join(near)}?" if near else f"known are {', '.join(ordered)}"
    return f"unknown internal action {name}; {hint}"
