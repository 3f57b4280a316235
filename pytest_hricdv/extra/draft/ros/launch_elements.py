"""The elements of launch files of XML and YAML, with their lines."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

import yaml

from pytest_hricdv.extra.draft.reading.sources import DraftError

INSTALL = (
    "the launch system reads it: source a distribution of ROS 2, or install launch, launch_ros and rclpy "
    "(docs/ros2.md#launch-files)"
)


@dataclass
class Entity:
    """An element of a launch file: `<node pkg="cell" exec="arm"/>`, or the same in YAML.

    Args:
        kind: `node`, `group`, `arg`.
        values: its attributes, as texts.
        parts: the elements in it.
        line: from 1.
    """

    kind: str
    values: dict[str, str]
    parts: list[Entity] = field(default_factory=list)
    line: int = 0


def entities(file: Path) -> Entity:
    """The root element of a launch file.

    Raises:
        DraftError: it is of Python, or no XML or YAML.
    """
    if file.suffix == ".py":
        raise DraftError(f"--launch={file}: is a launch file of Python: {INSTALL}")
    try:
        data = file.read_bytes()
        return _of_yaml(data) if file.suffix in (".yaml", ".yml") else _of_xml(data)
    except OSError as error:
        raise DraftError(f"--launch={file}: cannot be read: {error.strerror}") from None
    except expat.ExpatError as error:
        raise DraftError(f"--launch={file}:{error.lineno}: no XML: {expat.ErrorString(error.code)}") from None
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark is not None else 1
        raise DraftError(f"--launch={file}:{line}: no YAML: {error.problem}") from None
    except RecursionError:
        raise DraftError(f"--launch={file}: its elements are nested too deep") from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise DraftError(f"--launch={file}: no YAML: {' '.join(str(error).split())}") from None


def _of_xml(data: bytes) -> Entity:
    root = Entity("", {})
    around = [root]
    parser = expat.ParserCreate()

    def begin(name: str, attributes: dict[str, str]) -> None:
        made = Entity(name.replace("-", "_"), attributes, line=parser.CurrentLineNumber)
        around[-1].parts.append(made)
        around.append(made)

    parser.StartElementHandler = begin
    parser.EndElementHandler = lambda name: around.pop()
    parser.Parse(data, True)
    return root.parts[0]


def _of_yaml(data: bytes) -> Entity:
    tree = yaml.compose(data.decode("utf-8"), Loader=yaml.SafeLoader)
    root = _entity("launch", tree) if tree is not None else Entity("launch", {})
    return root.parts[0] if len(root.parts) == 1 and root.parts[0].kind == "launch" else root


def _entity(kind: str, node: yaml.Node, line: int = 0) -> Entity:
    made = Entity(kind.replace("-", "_"), {}, line=line or node.start_mark.line + 1)
    pairs = node.value if isinstance(node, yaml.MappingNode) else []
    if isinstance(node, yaml.SequenceNode):
        pairs = [pair for entry in node.value if isinstance(entry, yaml.MappingNode) for pair in entry.value]
    for key, value in pairs:
        if isinstance(value, yaml.ScalarNode):
            made.values[str(key.value)] = str(value.value)
        elif isinstance(value, yaml.SequenceNode) and key.value in ("remap", "param", "env", "arg"):
            made.parts += [_entity(key.value, entry) for entry in value.value]
        elif isinstance(value, yaml.SequenceNode) and key.value == "children":
            made.parts += _entity("children", value).parts
        else:
            made.parts.append(_entity(key.value, value, key.start_mark.line + 1))
    return made
