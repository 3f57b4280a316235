"""Writes the `NodeDriver` of a drafted `conftest.py`: topics, services, actions and parameters of a ROS 2 node."""

from __future__ import annotations

import ast
import json
import os

from pytest_hricdv.extra.draft.project.declarations import tuple_text
from pytest_hricdv.extra.draft.project.draft import Draft
from pytest_hricdv.extra.draft.ros_model import RosStart

_KEYWORDS = {
    "publisher": "publishers",
    "subscription": "subscriptions",
    "service": "services",
    "action server": "actions",
    "client": "clients",
    "action client": "action_clients",
}
"""Kind of an endpoint -> argument of the driver."""


def node_driver_lines(draft: Draft, start: RosStart) -> list[str]:
    """The statement that makes the driver."""
    lines = ["    driver = NodeDriver(", f"        {json.dumps(start.entry)},"]
    for kind, keyword in _KEYWORDS.items():
        declared = {endpoint.name: endpoint for endpoint in reversed(start.declared) if endpoint.kind == kind}
        lines += (
            ["        # TODO: what do others answer, and what do they do?"] if "client" in kind and declared else []
        )
        rows = [f"            {json.dumps(e.name)}: {json.dumps(e.type)},  # {e.location}"
                for e in reversed(declared.values())]  # fmt: skip
        lines += [f"        {keyword}={{", *rows, "        },"] if rows else []
    parameters: dict[str, str] = {}
    for parameter in draft.code.ros.parameters:
        if _is_constant(parameter.default):
            row = f"            {json.dumps(parameter.name)}: {parameter.default},  # {parameter.location}"
            parameters.setdefault(parameter.name, row)
    if parameters:
        lines += ["        # As the code declares them. TODO: with which values does your robot start it?"]
        lines += ["        parameters={", *parameters.values(), "        },"]
    lines += ["        says=says,"] if draft.inputs else []
    lines += [f'        person="{draft.person}",'] if draft.person != "person" else []
    return [*lines, "        manners=Manners(ANSWER_S, STAYS_S),", "        limit_s=LIMIT_S,", "    )"]


def ros2_lines(draft: Draft, start: RosStart) -> list[str]:
    """The declarations of the testbench for ROS 2."""
    folders = "".join(f'HERE / "{os.path.relpath(folder, draft.folder)}", ' for folder in start.interfaces)
    packages = list(dict.fromkeys(name.partition(".")[0] for name in draft.code.modules if "." in name))
    parts = [f"interfaces=({folders.rstrip()}),"] if folders else []
    parts += [f"packages={tuple_text(packages)},  # all of them see virtual time"] if packages else []
    if not parts:
        return ["        ros2=driver.ros2(),"]
    return ["        ros2=driver.ros2(", *(f"            {part}" for part in parts), "        ),"]


def _is_constant(text: str) -> bool:
    """Whether a default is one that a parameter file can have."""
    try:
        value = ast.literal_eval(text)
    except (ValueError, SyntaxError):
        return False
    return isinstance(value, bool | int | float | str)
