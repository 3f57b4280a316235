"""Classes of a draft for messages that have none in the code, and how they become the code's own texts and dicts."""

from __future__ import annotations

from pytest_hricdv.extra.draft.found.findings import Message
from pytest_hricdv.extra.draft.writing.drafted import Draft

CONVERTING = '''

def to_plain(message: Any) -> Any:
    """What the code gets for a message: its text, number, dict or tuple; a message of a class as it is."""
    form = getattr(message, "FORM", "")
    if not form:
        return message
    content: Any = {}
    for name, path in message.PATHS.items():
        content = _with(content, path, getattr(message, name))
    content = _with_tuples(content)
    if form == "line":
        return f"{content}\\n".encode()
    return json.dumps(content) if form == "json" else content


def _with(content: Any, path: tuple[str | int, ...], value: Any) -> Any:
    """The content, with a value where the path leads."""
    if not path:
        return value
    return {**content, path[0]: _with(content.get(path[0], {}), path[1:], value)}


def _with_tuples(content: Any) -> Any:
    """The content, where dicts of numbers are tuples."""
    if not isinstance(content, dict):
        return content
    parts = {key: _with_tuples(value) for key, value in content.items()}
    if parts and all(isinstance(key, int) for key in parts):
        return tuple(parts.get(number) for number in range(max(parts) + 1))
    return parts


def of_plain(value: Any, kinds: tuple[type[Any], ...]) -> Any:
    """The message for what the code said, of the first class that is like it; None, and a warning, where none is."""
    for kind in kinds:
        content = _read(value) if kind.FORM == "json" else value
        if isinstance(content, _LIKE[kind.FORM]) and not (kind.FORM == "number" and isinstance(content, bool)):
            return _filled(kind, content)
    if kinds and value is not None:
        classes = ", ".join(kind.__name__ for kind in kinds)
        warnings.warn(f"the code says {value!r}, which is no {classes}: no test sees it", stacklevel=2)
    return None


_LIKE: dict[str, tuple[type[Any], ...]] = {
    "text": (str, bytes, bool, Enum),
    "line": (str, bytes),
    "number": (int, float),
    "dict": (dict,),
    "json": (dict,),
    "tuple": (tuple, list),
}


def _filled(kind: type[Any], content: Any) -> Any:
    """A message with what the code said; a field of which it said nothing has its default."""
    values: dict[str, Any] = {}
    for part in fields(kind):
        value = content
        for step in kind.PATHS[part.name]:
            try:
                value = value[step]
            except (KeyError, IndexError, TypeError):
                value = None
        if value is not None:
            values[part.name] = _like(part.default, value)
    return kind(**values)


def _like(default: Any, value: Any) -> Any:
    """A value of the type that a field has."""
    if isinstance(default, bool):
        return bool(value)
    if isinstance(default, int | float):
        return type(default)(value) if isinstance(value, int | float) else default
    if isinstance(value, Enum):
        return text_of(value)
    return value.decode(errors="replace") if isinstance(value, bytes) else str(value)


def _read(text: Any) -> Any:
    """What a text of JSON holds; None where it is none."""
    try:
        return json.loads(text)
    except (TypeError, ValueError):
        return None
'''


OWN_CLASSES = ("state", "failure")
"""Forms of messages whose classes come with what says them."""


def plain_classes(draft: Draft) -> str:
    """The classes, and the functions that turn the code's own texts and dicts into them and back."""
    if not draft.plain:
        return ""
    states = "".join(_state(message) for message in draft.plain if message.form == "state")
    others = "".join(_class(message) for message in draft.plain if message.form not in OWN_CLASSES)
    return states + others + (CONVERTING if others else "")


def _state(message: Message) -> str:
    """The class of a state that the code only holds, and what looks at it."""
    return f'''

@dataclass(frozen=True)
class {message.name}:
    """The state that the robot holds in `{message.channel}` ({message.place}), and says nowhere."""

    name: str = ""


def look(run: Run, read: Callable[[], Any]) -> None:
    """Say the state whenever it is another one than at the last look. TODO: shorter ones are not seen."""
    port, last = run.bus.port("robot"), None
    while True:
        value = read()
        name = text_of(value) if isinstance(value, Enum) else str(value)
        if name != last:
            port.publish({message.name}(name))
        last = name
        run.kernel.sleep(STATE_EACH_S)
'''


def _class(message: Message) -> str:
    does = {"heard": "hears", "said": "says", "both": "hears and says"}[message.direction]
    lines = [
        "",
        "",
        "@dataclass(frozen=True)",
        f"class {message.name}:",
        f'    """A {message.form} that the code {does} through `{message.channel}` ({message.place})."""',
        "",
        f'    FORM: ClassVar[str] = "{message.form}"',
        "    PATHS: ClassVar[dict[str, tuple[str | int, ...]]] = {",
    ]
    for part, path in zip(message.fields, message.paths, strict=True):
        steps = ", ".join(f'"{step}"' if isinstance(step, str) else str(step) for step in path)
        lines.append(f'        "{part.name}": ({steps}{"," if len(path) == 1 else ""}),')
    lines += ["    }", ""]
    lines += [f"    {part.name}: {part.type} = {part.default}  # {part.place}" for part in message.fields]
    return "\n".join(lines) + "\n"
