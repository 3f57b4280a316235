"""`python -m tests.extra.ros2.names`: the names of the real extension of `rclpy`, with the members of its classes."""

from __future__ import annotations

import inspect
import json
import sys


def _members(value: object) -> list[str]:
    """Of a class; of an enumeration, only what it enumerates."""
    enumerated = getattr(value, "__members__", None)
    if enumerated is not None:
        return sorted(enumerated)
    return sorted(member for member in vars(value) if not member.startswith("_")) if inspect.isclass(value) else []


def main() -> int:
    """Print them as JSON; 3 where the extension cannot be loaded."""
    try:
        from rclpy import _rclpy_pybind11 as real  # type: ignore[import-not-found, attr-defined, unused-ignore]
    except ImportError as error:
        print(error, file=sys.stderr)
        return 3
    names = {name: getattr(real, name) for name in sorted(vars(real)) if not name.startswith("__")}
    members = {name: _members(value) for name, value in names.items()}
    print(json.dumps(members, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
