"""Messages of the code: classes that it publishes or subscribes, and what goes through queues, topics and streams."""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from pytest_hricdv.extra.draft.constants import Member, Reference, UnknownValueError, evaluate, is_enum, members
from pytest_hricdv.extra.draft.findings import Direction, FoundValue, Message, MessageField, Place
from pytest_hricdv.extra.draft.naming import snake, unit_of
from pytest_hricdv.extra.draft.sources import Function, Module, Scope, Sources, dotted_name, imported_name
from pytest_hricdv.extra.draft.value_flow import Call, ValueFlow, parameter_names, texts

SAYS = (
    "publish", "send", "emit", "put", "put_nowait", "notify", "broadcast", "say", "post", "fire", "announce", "push",
    "send_nowait", "publish_message", "send_message", "sendto", "output", "report_event", "reply", "respond",
)  # fmt: skip
"""Names of calls that hand a message on, without leading underscores."""

SUBSCRIBES = (
    "subscribe", "on", "listen", "register", "add_listener", "register_handler", "add_handler", "wait_for", "expect",
    "receive", "recv", "create_subscription", "subscribe_to", "listen_to", "inbox", "register_callback",
)  # fmt: skip
"""Names of calls whose argument is the class of a message that comes, or its topic."""

TAKES = ("get", "get_nowait", "recv", "receive", "wait", "poll", "take", "popleft", "next", "read", "receive_nowait")
"""Names of calls that return a message."""

CALLBACK = re.compile(r"^_*(on|handle|handler|receive|received|process|cb|callback)_|_(cb|callback|handler|received)$")
"""Names of functions that a framework calls with a message."""

QUEUES = (
    "queue.Queue",
    "queue.SimpleQueue",
    "asyncio.Queue",
    "multiprocessing.Queue",
    "queue.PriorityQueue",
    "janus.Queue",
)

_KINDS = {"bool": "bool", "int": "float", "float": "float", "str": "str"}
_QUOTED = re.compile(r"[\"'`]{1,2}([A-Za-z][\w .-]{0,40}?)[\"'`]{1,2}")


@dataclass
class Uses:
    """Where a class is said and heard."""

    said: list[Place] = field(default_factory=list)
    heard: list[Place] = field(default_factory=list)
    likely: list[Place] = field(default_factory=list)
    """Heard, by the name of a callback or by a test of its class."""
    channels: list[str] = field(default_factory=list)


def form_of(sources: Sources, scope: Scope) -> str:
    """How a class is made that can be a message; empty where it cannot."""
    node = scope.node
    assert isinstance(node, ast.ClassDef)
    for decorator in node.decorator_list:
        name = imported_name(scope.module, decorator.func if isinstance(decorator, ast.Call) else decorator)
        if name.rpartition(".")[2] == "dataclass":
            return "dataclass"
        if name in ("attr.s", "attrs.define", "attrs.frozen", "attr.define", "attr.frozen", "attr.attrs"):
            return "model"
    bases = {base.rpartition(".")[2] for base in sources.bases(scope)}
    if "NamedTuple" in bases:
        return "namedtuple"
    if "TypedDict" in bases:
        return "typeddict"
    if bases & {"BaseModel", "Struct"}:
        return "model"
    if any(form_of(sources, base) == "dataclass" for base in _own_bases(sources, scope)):
        return "dataclass"
    return "enum" if is_enum(sources, scope) else ""


def _own_bases(sources: Sources, scope: Scope) -> list[Scope]:
    assert isinstance(scope.node, ast.ClassDef)
    bases = [sources.class_of(scope.module, base) for base in scope.node.bases]
    return [base for base in bases if base is not None and base.node is not scope.node]


class MessageFinder:
    """Finds the messages of the code."""

    def __init__(self, sources: Sources, flow: ValueFlow) -> None:
        self._sources, self._flow = sources, flow
        self._uses: dict[int, Uses] = defaultdict(Uses)
        self._scopes: dict[int, Scope] = {}

    def messages(self) -> tuple[Message, ...]:
        """All messages, in the order of the code."""
        inside = self._inside_queues()
        for module, scope, node in self._flow.nodes:
            if isinstance(node, ast.Call):
                self._called(Call(module, scope, node), inside)
            elif isinstance(node, ast.MatchClass):
                self._tested(module, scope, node.cls, None)
            elif isinstance(node, ast.AnnAssign | ast.arg) and node.annotation is not None:
                self._annotated(module, scope, node, inside)
        for scope in self._sources.functions:
            self._callback(scope)
        messages = [self._message(key, uses) for key, uses in self._uses.items()]
        return tuple(
            sorted((message for message in messages if message is not None), key=lambda message: message.place)
        )

    def classes_in(self, expression: ast.AST | None, module: Module, scope: Scope | None) -> Iterator[Scope]:
        """Message classes whose instances (or members) an expression can be."""
        for node, where, at in self._flow.expressions(expression, module, scope):
            own = None
            if isinstance(node, ast.Call):
                own = self._sources.class_of(where, node.func) if isinstance(node.func, ast.expr) else None
                if dotted_name(node.func).rpartition(".")[2] in ("replace", "copy", "deepcopy") and node.args:
                    yield from self.classes_in(node.args[0], where, at)
                yield from self._returned(node, where)
            elif isinstance(node, ast.Attribute):
                own = self._sources.class_of(where, node.value)
                own = own if own is not None and is_enum(self._sources, own) else None
            elif isinstance(node, ast.Name) and at is not None:
                yield from self._of_parameter(node.id, at)
            if own is not None and form_of(self._sources, own):
                yield own

    def _returned(self, node: ast.Call, module: Module) -> Iterator[Scope]:
        name = dotted_name(node.func).rpartition(".")[2]
        for scope in self._flow.methods.get(name, ()):
            assert not isinstance(scope.node, ast.ClassDef)
            yield from self._in_annotation(scope.node.returns, scope.module)

    def _of_parameter(self, name: str, scope: Scope) -> Iterator[Scope]:
        assert not isinstance(scope.node, ast.ClassDef)
        arguments = scope.node.args
        for part in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs):
            if part.arg == name:
                yield from self._in_annotation(part.annotation, scope.module)

    def _in_annotation(self, annotation: ast.expr | None, module: Module, depth: int = 0) -> Iterator[Scope]:
        """Message classes that an annotation names, through unions and aliases."""
        if annotation is None or depth > 5:
            return
        if isinstance(annotation, ast.BinOp):
            yield from self._in_annotation(annotation.left, module, depth + 1)
            yield from self._in_annotation(annotation.right, module, depth + 1)
            return
        if isinstance(annotation, ast.Subscript) and dotted_name(annotation.value).endswith(("Union", "Optional")):
            parts = annotation.slice.elts if isinstance(annotation.slice, ast.Tuple) else [annotation.slice]
            for part in parts:
                yield from self._in_annotation(part, module, depth + 1)
            return
        if isinstance(annotation, ast.Constant) and isinstance(annotation.value, str) and not dotted_name(annotation):
            try:
                yield from self._in_annotation(ast.parse(annotation.value, mode="eval").body, module, depth + 1)
            except SyntaxError:
                return
            return
        own = self._sources.class_of(module, annotation)
        if own is not None:
            if form_of(self._sources, own):
                yield own
            return
        name = dotted_name(annotation)
        defined = self._sources.definition(module, name) if name else None
        if defined is not None and isinstance(defined[1], ast.Assign | ast.AnnAssign):
            yield from self._in_annotation(defined[1].value, defined[0], depth + 1)

    def _note(self, scope: Scope, kind: str, place: Place, channel: str = "") -> None:
        self._scopes[id(scope.node)] = scope
        uses = self._uses[id(scope.node)]
        getattr(uses, kind).append(place)
        if channel and channel not in uses.channels:
            uses.channels.append(channel)

    def _called(self, call: Call, inside: set[str]) -> None:
        name, node = _last(call.node.func).strip("_"), call.node
        place, receiver = call.module.place(node), _receiver(node)
        if name == "isinstance" and len(node.args) == 2:
            self._tested(call.module, call.scope, node.args[1], node.args[0])
        is_queue = name in ("put", "put_nowait", "get", "get_nowait")
        if is_queue and receiver in inside:
            return
        if name in SAYS or (
            receiver == "" and any(name.startswith(f"{verb}_") for verb in ("publish", "send", "emit"))
        ):
            for argument in (*node.args, *(keyword.value for keyword in node.keywords)):
                for scope in self.classes_in(argument, call.module, call.scope):
                    self._note(scope, "said", place, receiver if is_queue else "")
        if name in SUBSCRIBES:
            for argument in (*node.args, *(keyword.value for keyword in node.keywords)):
                parts = argument.elts if isinstance(argument, ast.Tuple | ast.List) else [argument]
                for part in parts:
                    own = self._sources.class_of(call.module, part)
                    if own is not None and form_of(self._sources, own):
                        self._note(own, "heard", place)

    def _tested(self, module: Module, scope: Scope | None, classes: ast.expr, value: ast.expr | None) -> None:
        """`isinstance(message, Order)` or `case Order():` of what was taken from somewhere."""
        parts = classes.elts if isinstance(classes, ast.Tuple) else [classes]
        if value is not None and not self._is_taken(value, module, scope):
            return
        for part in parts:
            own = self._sources.class_of(module, part)
            if own is not None and form_of(self._sources, own) not in ("", "enum"):
                self._note(own, "likely", module.place(part))

    def _is_taken(self, value: ast.expr, module: Module, scope: Scope | None) -> bool:
        for node, _, at in self._flow.expressions(value, module, scope):
            if isinstance(node, ast.Call) and _last(node.func).strip("_") in TAKES:
                return True
            if isinstance(node, ast.Name) and at is not None and not isinstance(at.node, ast.ClassDef):
                is_public = not at.node.name.startswith("_") or CALLBACK.search(at.node.name) is not None
                if is_public and node.id in parameter_names(at.node):
                    return True
        return False

    def _annotated(self, module: Module, scope: Scope | None, node: ast.AnnAssign | ast.arg, inside: set[str]) -> None:
        """`inbox: Queue[Order]`, of which the code takes, or to which it adds."""
        annotation = node.annotation
        if not isinstance(annotation, ast.Subscript):
            return
        last = dotted_name(annotation.value).rpartition(".")[2]
        if last not in (
            "Queue",
            "SimpleQueue",
            "Subscription",
            "Inbox",
            "Publisher",
            "Topic",
            "Channel",
            "Sink",
            "Source",
        ):
            return
        name = node.arg if isinstance(node, ast.arg) else dotted_name(node.target).rpartition(".")[2]
        key = name.strip("_")
        if key in inside:
            return
        puts, gets = self._sides(key)
        for own in self._in_annotation(
            annotation.slice if not isinstance(annotation.slice, ast.Tuple) else None, module
        ):
            if gets:
                self._note(own, "heard", gets[0], key)
            if puts:
                self._note(own, "said", puts[0], key)

    def _sides(self, key: str) -> tuple[list[Place], list[Place]]:
        puts, gets = [], []
        for module, _, node in self._flow.nodes:
            if isinstance(node, ast.Call) and _receiver(node) == key:
                if _last(node.func) in ("put", "put_nowait", "publish", "send"):
                    puts.append(module.place(node))
                elif _last(node.func) in TAKES:
                    gets.append(module.place(node))
            elif (
                isinstance(node, ast.AsyncFor | ast.For) and dotted_name(node.iter).rpartition(".")[2].strip("_") == key
            ):
                gets.append(module.place(node))
        return puts, gets

    def _inside_queues(self) -> set[str]:
        """Queues to which the code adds, and from which it takes itself."""
        names = {_receiver(call.node) for verb in ("put", "put_nowait") for call in self._flow.calls.get(verb, ())}
        return {name for name in names if name and all(self._sides(name))}

    def _callback(self, scope: Scope) -> None:
        function = scope.node
        assert not isinstance(function, ast.ClassDef)
        if not CALLBACK.search(function.name):
            return
        for part in (*function.args.posonlyargs, *function.args.args):
            for own in self._in_annotation(part.annotation, scope.module):
                self._note(own, "likely", scope.place)

    def _message(self, key: int, uses: Uses) -> Message | None:
        scope = self._scopes[key]
        heard = uses.heard or ([] if uses.said else uses.likely)
        if not heard and not uses.said:
            return None
        if len(uses.channels) == 0 and form_of(self._sources, scope) == "enum" and not uses.heard:
            return None  # a member among the arguments of a message
        direction: Direction = "both" if heard and uses.said else "heard" if heard else "said"
        assert isinstance(scope.node, ast.ClassDef)
        return Message(
            scope.node.name,
            snake(scope.node.name),
            scope.module.name,
            direction,
            self.fields(scope),
            scope.place,
            tuple(dict.fromkeys((*heard, *uses.said))),
            form_of(self._sources, scope),
            uses.channels[0] if uses.channels else "",
            certainty="certain" if uses.heard or uses.said else "likely",
        )

    def fields(self, scope: Scope) -> tuple[MessageField, ...]:
        """The fields of a message class, those of its bases first, with their values."""
        node = scope.node
        assert isinstance(node, ast.ClassDef)
        if is_enum(self._sources, scope):
            values = tuple(FoundValue(m.text, scope.module.place(s)) for m, s in members(self._sources, scope))
            return (MessageField("name", node.name, "str", scope.place, values, by_type=True),)
        fields = {part.name: part for base in _own_bases(self._sources, scope) for part in self.fields(base)}
        for statement in node.body:
            if isinstance(statement, ast.AnnAssign) and isinstance(statement.target, ast.Name):
                part = self._field(scope, statement)
                if part is not None:
                    fields[part.name] = part
        return tuple(self._with_values(scope, part, len(fields)) for part in fields.values())

    def _field(self, scope: Scope, statement: ast.AnnAssign) -> MessageField | None:
        assert isinstance(statement.target, ast.Name)
        written = ast.unparse(statement.annotation)
        if "ClassVar" in written:
            return None
        place = scope.module.place(statement)
        default = ast.unparse(statement.value) if statement.value is not None else ""
        name = statement.target.id
        kind, values = _KINDS.get(written.strip("\"'"), ""), tuple[FoundValue, ...]()
        annotation = statement.annotation
        own = self._sources.class_of(scope.module, annotation)
        if own is not None and is_enum(self._sources, own):
            values = tuple(FoundValue(m.text, own.module.place(s)) for m, s in members(self._sources, own))
            return MessageField(name, written, "str", place, values, "", default, by_type=True)
        if isinstance(annotation, ast.Name):
            defined = self._sources.definition(scope.module, annotation.id)
            if (
                defined is not None
                and isinstance(defined[1], ast.Assign | ast.AnnAssign)
                and defined[1].value is not None
            ):
                annotation = defined[1].value
        if isinstance(annotation, ast.Subscript) and dotted_name(annotation.value).rpartition(".")[2] == "Literal":
            parts = annotation.slice.elts if isinstance(annotation.slice, ast.Tuple) else [annotation.slice]
            contents = [self._literal(scope.module, part) for part in parts]
            chosen = tuple(
                FoundValue(text, scope.module.place(annotation)) for text in contents if isinstance(text, str)
            )
            kind = "str" if chosen else "float"
            return MessageField(name, written, kind, place, chosen, "", default, by_type=True)
        unit = unit_of(name) if kind == "float" else ""
        return MessageField(name, written, kind, place, (), unit, default)

    def _literal(self, module: Module, node: ast.expr) -> object:
        try:
            value = evaluate(self._sources, module, node)
        except UnknownValueError:
            return None
        return value.text if isinstance(value, Member) else value

    def _with_values(self, scope: Scope, part: MessageField, fields: int) -> MessageField:
        """The same with the texts that it is made of, or compared with; of a docstring where the code says none."""
        if part.kind != "str" or part.by_type:
            return part
        found: dict[str, FoundValue] = {}
        for text, place in {**self._made_of(scope, part.name), **self._compared(scope, part.name)}.items():
            found.setdefault(text, FoundValue(text, place))
        for text in self._documented(scope, part.name, fields):
            found.setdefault(text, FoundValue(text, scope.place, certainty="likely"))
        return replace(part, values=tuple(found.values()))

    def _made_of(self, scope: Scope, name: str) -> dict[str, Place]:
        """Texts with which a message is made."""
        assert isinstance(scope.node, ast.ClassDef)
        names = [
            s.target.id for s in scope.node.body if isinstance(s, ast.AnnAssign) and isinstance(s.target, ast.Name)
        ]
        found: dict[str, Place] = {}
        for call in self._flow.calls.get(scope.node.name, ()):
            value = next((keyword.value for keyword in call.node.keywords if keyword.arg == name), None)
            index = names.index(name) if name in names else len(names)
            if value is None and index < len(call.node.args):
                value = call.node.args[index]
            if value is not None:
                found |= texts(self._flow.constants(value, call.module, call.scope))
                found |= self._forwarded(value, call.module, call.scope)
        return found

    def _forwarded(self, value: ast.expr, module: Module, scope: Scope | None) -> dict[str, Place]:
        """Texts of a message's field that is said back in another one, as far as it is compared."""
        found: dict[str, Place] = {}
        for node, _, at in self._flow.expressions(value, module, scope):
            if isinstance(node, ast.Name) and at is not None:
                found |= self._compared_names(node.id, at)
        return found

    def _compared(self, scope: Scope, name: str) -> dict[str, Place]:
        """Texts that a field is compared with, or looked up by, directly or as a parameter that gets it."""
        assert isinstance(scope.node, ast.ClassDef)
        found: dict[str, Place] = {}
        for module, at, node in self._flow.nodes:
            if isinstance(node, ast.Attribute) and node.attr == name and self._is_of(node.value, scope, module, at):
                for holder in self._compared_at(node, module, at):
                    found |= holder
        return found

    def _is_of(self, expression: ast.expr, scope: Scope, module: Module, at: Scope | None) -> bool:
        """Whether an expression can be a message of this class: made, taken of its subscription, or annotated."""
        assert isinstance(scope.node, ast.ClassDef)
        if dotted_name(expression) == "self":
            return False
        for own in self.classes_in(expression, module, at):
            return own.node is scope.node
        for node, where, place in self._flow.expressions(expression, module, at):
            if (
                isinstance(node, ast.Call)
                and _last(node.func).strip("_") in TAKES
                and isinstance(node.func, ast.Attribute)
            ):
                kinds = list(self._subscribed(node.func.value, where, place))
                return any(kind.node is scope.node for kind in kinds) if kinds else True
        return isinstance(expression, ast.Name | ast.Attribute) and not isinstance(expression, ast.Call)

    def _subscribed(self, receiver: ast.expr, module: Module, scope: Scope | None) -> Iterator[Scope]:
        for node, where, _ in self._flow.expressions(receiver, module, scope):
            if isinstance(node, ast.Call) and _last(node.func).strip("_") in SUBSCRIBES:
                for argument in node.args:
                    own = self._sources.class_of(where, argument)
                    if own is not None:
                        yield own

    @property
    def _parents(self) -> dict[int, ast.AST]:
        parents: dict[int, ast.AST] | None = self.__dict__.get("_parent_of")
        if parents is None:
            parents = {
                id(child): node
                for module in self._sources.modules
                for node in ast.walk(module.tree)
                for child in ast.iter_child_nodes(node)
            }
            self.__dict__["_parent_of"] = parents
        return parents

    def _compared_at(
        self, node: ast.AST, module: Module, scope: Scope | None, depth: int = 0
    ) -> Iterator[dict[str, Place]]:
        """What is compared with an expression, where it stands and wherever it goes from there."""
        parent = self._parents.get(id(node))
        if parent is None or depth > 5:
            return
        if isinstance(parent, ast.Compare):
            for other in (parent.left, *parent.comparators):
                if other is not node:
                    yield self._texts_of(other, module, scope)
        elif isinstance(parent, ast.Match):
            for case in parent.cases:
                for value in ast.walk(case.pattern):
                    if isinstance(value, ast.MatchValue):
                        yield self._texts_of(value.value, module, scope)
        elif isinstance(parent, ast.Subscript) and parent.slice is node:
            yield self._texts_of(parent.value, module, scope)
        elif isinstance(parent, ast.Await | ast.NamedExpr | ast.BoolOp | ast.UnaryOp):
            yield from self._compared_at(parent, module, scope, depth + 1)
        elif isinstance(parent, ast.Attribute) and parent.attr in ("strip", "lower", "upper", "value", "decode"):
            grand = self._parents.get(id(parent), parent)
            yield from self._compared_at(grand if isinstance(grand, ast.Call) else parent, module, scope, depth + 1)
        elif isinstance(parent, ast.Assign) and scope is not None:
            for target in parent.targets:
                if isinstance(target, ast.Name):
                    yield self._compared_names(target.id, scope, depth + 1)
        elif isinstance(parent, ast.Call) and node in parent.args:
            yield from self._compared_in_call(parent, node, module, scope, depth)

    def _compared_in_call(
        self, call: ast.Call, node: ast.AST, module: Module, scope: Scope | None, depth: int
    ) -> Iterator[dict[str, Place]]:
        if isinstance(call.func, ast.Attribute) and call.func.attr == "get":
            yield self._texts_of(call.func.value, module, scope)
        for method in self._flow.methods.get(_last(call.func), ()):
            assert not isinstance(method.node, ast.ClassDef)
            names = parameter_names(method.node)[1 if method.owner is not None else 0 :]
            index = call.args.index(node) if isinstance(node, ast.expr) else 0
            if index < len(names):
                yield self._compared_names(names[index], method, depth + 1)

    def _compared_names(self, name: str, scope: Scope, depth: int = 0) -> dict[str, Place]:
        found: dict[str, Place] = {}
        if depth > 5:
            return found
        for node in ast.walk(scope.node):
            if isinstance(node, ast.Name) and node.id == name and isinstance(node.ctx, ast.Load):
                for texts_ in self._compared_at(node, scope.module, scope, depth + 1):
                    found |= texts_
        return found

    def _texts_of(self, expression: ast.expr, module: Module, scope: Scope | None) -> dict[str, Place]:
        """A text, or those in a collection, or the keys of a table."""
        found: dict[str, Place] = {}
        values = self._flow.constants(expression, module, scope)
        place = module.place(expression)
        for value in [*values, *self._flow.elements(expression, module, scope)]:
            if isinstance(value, str | Member) and not isinstance(value, Reference):
                found |= texts({value: values.get(value, place)})
        return found

    def _documented(self, scope: Scope, name: str, fields: int) -> list[str]:
        """Texts in quotation marks that the docstring has for a field."""
        assert isinstance(scope.node, ast.ClassDef)
        text = ast.get_docstring(scope.node) or ""
        line = re.search(rf"^\s*{re.escape(name)}(?:\s*\([^)]*\))?:(.*)$", text, re.MULTILINE)
        written = line.group(1) if line else text if fields == 1 else ""
        quoted = [found for found in _QUOTED.findall(written) if "`" not in found]
        return quoted if len(quoted) > 1 and not re.search(r"`\w+\.\w+", written) else []


def _receiver(node: ast.Call) -> str:
    """On what a method is called, its last name without underscores: `self._jobs.put(1)` -> `jobs`."""
    if not isinstance(node.func, ast.Attribute):
        return ""
    return dotted_name(node.func.value).rpartition(".")[2].strip("_")


def _last(node: ast.AST) -> str:
    return node.attr if isinstance(node, ast.Attribute) else node.id if isinstance(node, ast.Name) else ""


def function_of(scope: Scope) -> Function:
    """The function of a scope that is no class."""
    assert not isinstance(scope.node, ast.ClassDef)
    return scope.node
