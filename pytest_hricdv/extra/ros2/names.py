"""Checks and expands names of topics, services and nodes as ROS 2 does.

The functions with `_fault` return what is wrong with a name; `expand` makes a full name of a relative or private one.
`contexts` uses them for each node, and `extension` gives them to `rclpy`. Source: the ROS 2 design article "Topic and
Service name mapping".
"""

from __future__ import annotations

import re

NameFault = tuple[str, int]
"""What is wrong with a name, and the index of the wrong character."""

_MAX_LENGTH = 255  # of rmw, RMW_NODE_NAME_MAX_NAME_LENGTH
_Rules = tuple[tuple[str, str], ...]
"""Pairs of a pattern that must not match a name, and the message if it does."""

_NODE: _Rules = (
    (r"\A\Z", "node name must not be empty"),
    (r"[^A-Za-z0-9_]", "node name must not contain characters other than alphanumerics or '_'"),
    (r"\A[0-9]", "node name must not start with a number"),
    (f"(?<=\\A.{{{_MAX_LENGTH}}}).", f"node name length should not exceed '{_MAX_LENGTH}'"),
)
_FULL: _Rules = (
    (r"\A\Z", "must not be empty"),
    (r"\A[^/]", "must be absolute, it must lead with a '/'"),
    (r"/\Z", "must not end with a '/'"),
    (r"[^A-Za-z0-9_/]", "must not contain characters other than alphanumerics, '_', or '/'"),
    (r"(?<=/)/", "must not contain repeated '/'"),
    (r"(?<=/)[0-9]", "must not have a token that starts with a number"),
)
_TOPIC: _Rules = (
    (r"\A\Z", "topic name must not be empty string"),
    (r"/\Z", "topic name must not end with a forward slash"),
    (
        r"[^A-Za-z0-9_/~{}]",
        "topic name must not contain characters other than alphanumerics, '_', '~', '{', or '}'",
    ),
    (r"(?<!\A)~", "topic name must not have '~' anywhere but as the first character"),
    (r"(?<=\A~)[^/]", "topic name must not have a tilde '~' that is not followed by a forward slash '/'"),
    (r"(?<![^/])[0-9]", "topic name token must not start with a number"),
)


def _first_fault(name: str, rules: _Rules) -> NameFault | None:
    faults = ((text, match.start()) for pattern, text in rules if (match := re.search(pattern, name)))
    return next(faults, None)


def node_name_fault(name: str) -> NameFault | None:
    """What is wrong with a node's name; None for nothing."""
    return _first_fault(name, _NODE)


def full_topic_name_fault(name: str, kind: str = "topic name") -> NameFault | None:
    """What is wrong with an expanded name; None for nothing."""
    fault = _first_fault(name, _FULL)
    return (f"{kind} {fault[0]}", fault[1]) if fault else None


def namespace_fault(name: str) -> NameFault | None:
    """What is wrong with a namespace; None for nothing."""
    return None if name == "/" else full_topic_name_fault(name, "namespace")


def topic_name_fault(name: str) -> NameFault | None:
    """What is wrong with a name as code gives it, which may be relative, private or have substitutions."""
    fault = _first_fault(name, _TOPIC)
    braces = re.match(r"[^{}]*(?:\{[^{}]*\}[^{}]*)*", name)
    if fault or braces is None or braces.end() == len(name):
        return fault
    nested = re.match(r"\{[^{}]*(?=\{)", name[braces.end() :])
    index = braces.end() + (nested.end() if nested else 0)
    return "topic name must not have unmatched (unbalanced) curly braces '{}'", index


def expand(name: str, node: str, namespace: str) -> str:
    """The full name that code of a node means.

    Raises:
        ValueError: the name is wrong, or has a substitution that is not known.
    """
    for kind, fault in (
        ("topic name", topic_name_fault(name)),
        ("node name", node_name_fault(node)),
        ("namespace", namespace_fault(namespace)),
    ):
        if fault:
            raise ValueError(f"{kind} is invalid: {fault[0]}, at index {fault[1]}: '{name}'")
    full_node = f"{namespace.rstrip('/')}/{node}"
    substitutes = {"node": node, "ns": namespace, "namespace": namespace}

    def substitute(match: re.Match[str]) -> str:
        if match[1] not in substitutes:
            raise ValueError(f"topic name is invalid: unknown substitution '{match[0]}' in '{name}'")
        return substitutes[match[1]]

    expanded = re.sub(r"\{(\w*)\}", substitute, name)
    if expanded.startswith("~"):
        return full_node + expanded[1:]
    return expanded if expanded.startswith("/") else f"{namespace.rstrip('/')}/{expanded}"
