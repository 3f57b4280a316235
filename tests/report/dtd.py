"""What Cobertura's DTD (`coverage-04`) asks of a file, as far as it concerns a file without methods."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET

#: Element -> pattern of its children's names (each followed by a blank), attributes it must have, ones it may have.
ELEMENTS: dict[str, tuple[str, str, str]] = {
    "coverage": (
        "(sources )?packages ",
        "line-rate branch-rate lines-covered lines-valid branches-covered branches-valid complexity version timestamp",
        "",
    ),
    "sources": ("(source )*", "", ""),
    "source": ("", "", ""),
    "packages": ("(package )*", "", ""),
    "package": ("classes ", "name line-rate branch-rate complexity", ""),
    "classes": ("(class )*", "", ""),
    "class": ("methods lines ", "name filename line-rate branch-rate complexity", ""),
    "methods": ("(method )*", "", ""),
    "lines": ("(line )*", "", ""),
    "line": ("(conditions )*", "number hits", "branch condition-coverage"),
    "conditions": ("(condition )*", "", ""),
    "condition": ("", "number type coverage", ""),
}


def faults(element: ET.Element) -> list[str]:
    """Where an element and what is in it break the DTD."""
    if element.tag not in ELEMENTS:
        return [f"there is no element {element.tag}"]
    children, required, optional = ELEMENTS[element.tag]
    broken = []
    if not re.fullmatch(children, "".join(f"{child.tag} " for child in element)):
        broken.append(f"{element.tag} has {[child.tag for child in element]}, expected {children}")
    missing = set(required.split()) - set(element.attrib)
    surplus = set(element.attrib) - set(required.split()) - set(optional.split())
    if missing or surplus:
        broken.append(f"{element.tag} lacks {sorted(missing)}, has {sorted(surplus)} too many")
    return broken + [fault for child in element for fault in faults(child)]
