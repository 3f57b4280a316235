"""How a drafted testbench starts the nodes: one, those of a launch file, or the launch file itself."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import Any

from pytest_hricdv.declarations.ros2 import IGNORED
from pytest_hricdv.extra.draft.found.launched import LaunchedNodes, StartedNode
from pytest_hricdv.extra.draft.found.nodes import RosStart
from pytest_hricdv.extra.draft.writing.drafted import Draft


def started_lines(draft: Draft, start: RosStart) -> list[str]:
    """The lines of `run` that start the nodes."""
    if start.launch is not None:
        return _launch(draft, start, start.launch)
    if not start.nodes:
        return [f'    ros = run.ros2(RosNode(entry="{start.entry}", parameters=[PARAMETERS]))']
    lines = ["    ros = run.ros2("]
    for entry, node in start.nodes:
        lines.append(f"        RosNode({', '.join(_arguments(draft, entry, node))}),  # {node.place}")
    lines += [f"        # TODO: {name} is no Python: what does it do for the others?" for name in start.left_out]
    return [*lines, "    )"]


def _arguments(draft: Draft, entry: str, node: StartedNode) -> list[str]:
    made = [f"entry={json.dumps(entry)}"]
    made += [
        f"{name}={json.dumps(value)}" for name, value in (("name", node.name), ("namespace", _absolute(node))) if value
    ]
    if node.remappings:
        made.append(f"remappings=[{', '.join(f'({json.dumps(a)}, {json.dumps(b)})' for a, b in node.remappings)}]")
    if node.parameters:
        made.append(f"parameters=[{', '.join(_parameters(draft, value) for value in node.parameters)}]")
    if node.arguments:
        made.append(f"arguments=[{', '.join(json.dumps(word) for word in node.arguments)}]")
    return made


def _absolute(node: StartedNode) -> str:
    return f"/{node.namespace.strip('/')}" if node.namespace.strip("/") else ""


def _parameters(draft: Draft, value: Mapping[str, Any] | str) -> str:
    if isinstance(value, str):
        return f"str(HERE / {json.dumps(os.path.relpath(value, draft.folder))})"
    return "{" + ", ".join(f"{json.dumps(name)}: {content!r}" for name, content in value.items()) + "}"


def _launch(draft: Draft, start: RosStart, launch: LaunchedNodes) -> list[str]:
    file = os.path.relpath(launch.file, draft.folder)
    lines = ["    ros = run.ros2(", "        Launch(", f"            HERE / {json.dumps(file)},"]
    if launch.arguments:
        pairs = ", ".join(f"{json.dumps(name)}: {json.dumps(value)}" for name, value in launch.arguments.items())
        lines.append(f"            arguments={{{pairs}}},")
    if start.left_out:
        lines += [
            "            executables={",
            *(
                f'                {json.dumps(name)}: "{IGNORED}",  # TODO: what does it do for the others?'
                for name in start.left_out
            ),
            "            },",
        ]
    return [*lines, "        )", "    )"]
