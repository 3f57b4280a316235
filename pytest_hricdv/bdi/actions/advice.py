"""What to write instead of an internal action that there is not: by what it does, where that is known."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

_NAME_SPACES = "what is to be known of a name space is a belief in it, as ns::kind(local)"

_INSTEAD = {
    ".assert": "beliefs are added with +b",
    ".retract": "beliefs are deleted with -b, all of a kind with .abolish",
    ".copy": "terms do not change: use the variable; with new variables, .copy_term",
    ".foreach": "use for (condition) { ... }, or .foreach(condition, { ... })",
    ".forall": "use for (condition) { ... }",
    ".if_then_else": "use if (condition) { ... } else { ... }, or .if_then_else(condition, { ... }, { ... })",
    ".if": "use if (condition) { ... } else { ... }",
    ".while": "use while (condition) { ... }",
    ".for": "use for (condition) { ... }",
    ".loop": "use while (condition) { ... }, or .loop(condition, { ... })",
    ".include": 'use the directive { include("file.asl") }',
    ".get_src_info": "where a statement is, a failure plan is told: -!g[code_src(File), code_line(Line)]",
    ".join": "it is part of .fork: write .fork(and, { ... }, { ... }), or !a |&| !b",
    ".list_files": "runs read no folders: what there is to choose from is a list of beliefs",
    ".namespace_get_prop": _NAME_SPACES,
    ".namespace_set_prop": _NAME_SPACES,
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
    "math.power": "powers are written X ** Y",
    "math.pow": "powers are written X ** Y",
    "math.mod": "the remainder is written X mod Y",
}
"""What there is instead, by the name of what there is not."""

_OWN_PACKAGES = ("math.", "system.")
"""Functions here, under the names that Jason gives them; everything else with a name before the dot is a Java class."""

_NAMES_OF_JASON = "fork get_src_info include join list_files namespace_get_prop namespace_set_prop"
_OF_JASON = {f".{name}" for name in _NAMES_OF_JASON.split()}
"""What Jason 1.4.2 or 3.3 has: no slip of a model that calls it."""


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
    # Below difflib's own cutoff of 0.6: for a name that is wrong for certain, a far guess beats the whole list.
    near = difflib.get_close_matches(name, ordered, n=3, cutoff=0.5)
    hint = f"did you mean {' or '.join(near)}?" if near else f"known are {', '.join(ordered)}"
    return f"unknown internal action {name}; {hint}"
