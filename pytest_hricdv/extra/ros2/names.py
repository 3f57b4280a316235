"""Names of topics, services and nodes: checked and expanded as ROS 2 defines it (design article "Topic and Service name
mapping")."""

from __future__ import annotations

import re

NameFault = tuple[str, int]
"""What is wrong with a name, and the index of the character that is."""

_MAX_LENGTH = 255  # of rmw, RMW_NODE_NAME_MAX_NAME_LENGTH


def node_name_fault(name: str) -> NameFault | None:
    """What is wrong with the name of a node; None if nothing is."""
    if not name:
        return "node name must not be empty", 0
    wrong = re.search(r"[^A-Za-z0-9_]", name)
    if wrong:
        return "node name must not contain characters other than alphanumerics or '_'", wrong.start()
    if name[0].isdigit():
        return "node name must not start with a number", 0
    if len(name) > _MAX_LENGTH:
        return f"node name length should not exceed '{_MAX_LENGTH}'", _MAX_LENGTH
    return None


def full_topic_name_fault(name: str, kind: str = "topic name") -> NameFault | None:
    """What is wrong with a name that is not to be expanded any more; None if nothing is."""
    if not name:
        return f"{kind} must not be empty", 0
    if name[0] != "/":
        return f"{kind} must be absolute, it must lead with a '/'", 0
    if name[-1] == "/":
        return f"{kind} must not end with a '/'", len(name) - 1
    wrong = re.search(r"[^A-Za-z0-9_/]", name)
    if wrong:
        return f"{kind} must not contain characters other than alphanumerics, '_', or '/'", wrong.start()
    doubled = name.find("//")
    if doubled >= 0:
        return f"{kind} must not contain repeated '/'", doubled + 1
    number = re.search(r"/[0-9]", name)
    if number:
        return f"{kind} must not have a token that starts with a number", number.start() + 1
    return None


def namespace_fault(name: str) -> NameFault | None:
    """What is wrong with a namespace; None if nothing is."""
    return None if name == "/" else full_topic_name_fault(name, "namespace")


def topic_name_fault(name: str) -> NameFault | None:
    """What is wrong with a name as code gives it, which may be relative, private or have substitutions."""
    if not name:
        return "topic name must not be empty string", 0
    if name[-1] == "/":
        return "topic name must not end with a forward slash", len(name) - 1
    wrong = re.search(r"[^A-Za-z0-9_/~{}]", name)
    if wrong:
        return "topic name must not contain characters other than alphanumerics, '_', '~', '{', or '}'", wrong.start()
    if "~" in name[1:]:
        return "topic name must not have '~' anywhere but as the first character", name.index("~", 1)
    if name[0] == "~" and len(name) > 1 and name[1] != "/":
        return "topic name must not have a tilde '~' that is not followed by a forward slash '/'", 1
    number = re.match(r"[0-9]", name) or re.search(r"/[0-9]", name)
    if number:
        return "topic name token must not start with a number", number.end() - 1
    return _brace_fault(name)


def _brace_fault(name: str) -> NameFault | None:
    opened = -1
    for index, character in enumerate(name):
        if character == "{" and opened < 0:
            opened = index
        elif character in "{}" and (character == "{") == (opened >= 0):
            return "topic name must not have unmatched (unbalanced) curly braces '{}'", index
        elif character == "}":
            opened = -1
    return ("topic name must not have unmatched (unbalanced) curly braces '{}'", opened) if opened >= 0 else None


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
