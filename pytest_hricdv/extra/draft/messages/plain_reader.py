"""What code reads of a value that has no class, and what it makes one of: texts, keys of dicts, places of tuples."""

from __future__ import annotations

import ast

from pytest_hricdv.extra.draft.messages.plain_value import PlainValue, sentences, words_after
from pytest_hricdv.extra.draft.reading.constants import Member
from pytest_hricdv.extra.draft.reading.naming import unit_of
from pytest_hricdv.extra.draft.reading.sources import Module, Scope, Sources, dotted_name, imported_name
from pytest_hricdv.extra.draft.reading.type_tables import is_single_dispatch
from pytest_hricdv.extra.draft.reading.value_flow import ValueFlow, argument_of, parameter_names

MAX_DEPTH = 6
"""Calls, names and attributes that a value is followed through (chosen)."""

_TEXT_METHODS = ("strip", "lstrip", "rstrip", "lower", "upper", "decode", "casefold", "title")
_TEXT_ONLY = ("split", "partition", "rpartition", "format", "removeprefix", "splitlines", "replace")
_DICT_ONLY = ("items", "keys", "values", "update")
_CLOCKS = ("time", "monotonic", "perf_counter", "process_time", "time_ns", "monotonic_ns", "perf_counter_ns")
"""Calls that return a time."""

_NUMBER_CALLS = ("float", "int", "abs", "min", "max", "round", "sleep", "sqrt", "hypot", "radians", "degrees")

Use = tuple[ast.AST, Module, Scope | None]
"""An expression that is the value, where it stands."""


class PlainReader:
    """Follows values without a class through the code."""

    def __init__(self, sources: Sources, flow: ValueFlow) -> None:
        self._sources, self._flow = sources, flow
        self._parents = {id(child): node for _, _, node in flow.nodes for child in ast.iter_child_nodes(node)}
        self._seen: set[int] = set()

    def parent(self, node: ast.AST) -> ast.AST | None:
        """The node around another one, within a statement of a module."""
        return self._parents.get(id(node))

    def read(self, node: ast.AST, module: Module, scope: Scope | None, value: PlainValue) -> None:
        """Add what is done with an expression, here and wherever it goes."""
        self._seen = set()
        self._used(node, module, scope, value, 0)

    def read_name(self, name: str, scope: Scope, value: PlainValue) -> None:
        """Add what a function does with a name of its own."""
        self._seen = set()
        self._named(name, scope, value, 0)

    def _named(self, name: str, scope: Scope, value: PlainValue, depth: int) -> None:
        for node in ast.walk(scope.node):
            if isinstance(node, ast.Name) and node.id == name and isinstance(node.ctx, ast.Load):
                self._used(node, scope.module, scope, value, depth + 1)

    def read_global(self, name: str, module: Module, value: PlainValue, depth: int = 0) -> None:
        """Add what the top of a module does with a name."""
        for where, scope, node in self._flow.nodes:
            is_name = isinstance(node, ast.Name) and node.id == name and isinstance(node.ctx, ast.Load)
            if scope is None and where is module and is_name:
                self._used(node, module, None, value, depth + 1)

    def _used(self, node: ast.AST, module: Module, scope: Scope | None, value: PlainValue, depth: int) -> None:
        parent = self.parent(node)
        if parent is None or depth > MAX_DEPTH or id(node) in self._seen:
            return
        self._seen.add(id(node))
        if isinstance(parent, ast.Await | ast.NamedExpr):
            if isinstance(parent, ast.NamedExpr) and scope is not None:
                self._named(parent.target.id, scope, value, depth)
            self._used(parent, module, scope, value, depth)
        elif isinstance(parent, ast.Compare):
            self._compared(parent, node, module, scope, value)
        elif isinstance(parent, ast.Match) and parent.subject is node:
            for case in parent.cases:
                self._matched(case.pattern, module, scope, value, depth)
        elif isinstance(parent, ast.Subscript):
            self._subscripted(parent, node, module, scope, value, depth)
        elif isinstance(parent, ast.Attribute):
            self._attribute(parent, module, scope, value, depth)
        elif isinstance(parent, ast.Assign | ast.AnnAssign):
            for target in parent.targets if isinstance(parent, ast.Assign) else [parent.target]:
                self._assigned(target, module, scope, value, depth)
        elif isinstance(parent, ast.Call):
            self._argument(parent, node, module, scope, value, depth)
        elif isinstance(parent, ast.keyword):
            call = self.parent(parent)
            if isinstance(call, ast.Call):
                self._argument(call, node, module, scope, value, depth)
        elif isinstance(parent, ast.Return) and scope is not None and not isinstance(scope.node, ast.ClassDef):
            for call_ in self._flow.calls.get(scope.node.name, ()):
                self._used(call_.node, call_.module, call_.scope, value, depth + 1)
        elif isinstance(parent, ast.BinOp | ast.AugAssign):
            other = parent.value if isinstance(parent, ast.AugAssign) else parent.left
            other = parent.right if isinstance(parent, ast.BinOp) and other is node else other
            is_text = isinstance(other, ast.JoinedStr) or isinstance(getattr(other, "value", None), str)
            value.is_number |= not is_text
        elif isinstance(parent, ast.UnaryOp) and isinstance(parent.op, ast.USub):
            value.is_number = True
        elif (isinstance(parent, ast.If | ast.While | ast.IfExp) and parent.test is node) or isinstance(
            parent, ast.UnaryOp
        ):
            value.is_bool = True
        elif isinstance(parent, ast.BoolOp):
            self._used(parent, module, scope, value, depth)

    def _compared(
        self, parent: ast.Compare, node: ast.AST, module: Module, scope: Scope | None, value: PlainValue
    ) -> None:
        others = [part for part in (parent.left, *parent.comparators) if part is not node]
        is_in = isinstance(parent.ops[0], ast.In | ast.NotIn)
        for other in others:
            place = module.place(other)
            constants = dict(self._flow.constants(other, module, scope))
            constants |= dict.fromkeys(self._flow.elements(other, module, scope), place)
            texts = [content for content in constants if isinstance(content, str)]
            if is_in and node is not parent.left:  # `"speed" in message`: a key, or a part of a text
                for text in texts:
                    value.key(text, place)
                continue
            value.texts |= {text: place for text in texts if text}
            value.texts |= {b.decode(errors="replace"): place for b in constants if isinstance(b, bytes) and b}
            value.is_bytes |= any(isinstance(content, bytes) for content in constants)
            value.numbers |= {
                float(c): place for c in constants if isinstance(c, int | float) and not isinstance(c, bool)
            }
            value.is_object |= any(isinstance(content, Member) for content in constants)
            value.is_bool |= any(isinstance(content, bool) for content in constants)
            value.is_number |= any(
                isinstance(content, int | float) and not isinstance(content, bool) for content in constants
            )
            value.is_number |= any(isinstance(op, ast.Lt | ast.Gt | ast.LtE | ast.GtE) for op in parent.ops)

    def _matched(
        self, pattern: ast.pattern, module: Module, scope: Scope | None, value: PlainValue, depth: int
    ) -> None:
        place = module.place(pattern)
        if isinstance(pattern, ast.MatchOr):
            for part in pattern.patterns:
                self._matched(part, module, scope, value, depth)
        elif isinstance(pattern, ast.MatchValue):
            for content in self._flow.constants(pattern.value, module, scope):
                if isinstance(content, str | bytes):
                    text = content if isinstance(content, str) else content.decode(errors="replace")
                    value.texts.setdefault(text, place)
                value.is_object |= isinstance(content, Member)
        elif isinstance(pattern, ast.MatchMapping):
            for key, part in zip(pattern.keys, pattern.patterns, strict=True):
                for name in self._flow.constants(key, module, scope):
                    if isinstance(name, str):
                        self._matched(part, module, scope, value.key(name, place), depth)
        elif isinstance(pattern, ast.MatchSequence):
            for number, part in enumerate(pattern.patterns):
                if isinstance(part, ast.MatchAs) and part.name:
                    value.names.setdefault(number, part.name)
                if not isinstance(part, ast.MatchStar):
                    self._matched(part, module, scope, value.item(number, place), depth)
        elif isinstance(pattern, ast.MatchAs):
            if pattern.pattern is not None:
                self._matched(pattern.pattern, module, scope, value, depth)
            if pattern.name and scope is not None:
                self._named(pattern.name, scope, value, depth)
        elif isinstance(pattern, ast.MatchClass):
            kind = dotted_name(pattern.cls)
            value.is_text |= kind == "str"
            value.is_number |= kind in ("int", "float")
            value.is_object |= kind not in ("str", "int", "float", "dict", "tuple", "list", "bool", "bytes")

    def _subscripted(
        self, parent: ast.Subscript, node: ast.AST, module: Module, scope: Scope | None, value: PlainValue, depth: int
    ) -> None:
        place = module.place(node)
        if parent.value is not node:  # a table is looked up by it
            constants = self._flow.constants(parent.value, module, scope)
            for table in constants:
                value.texts |= {key: place for key, _ in getattr(table, "pairs", ()) if isinstance(key, str)}
            return
        if not isinstance(parent.ctx, ast.Load):
            return
        for index in self._flow.constants(parent.slice, module, scope):
            if isinstance(index, str):
                self._used(parent, module, scope, value.key(index, place), depth + 1)
            elif isinstance(index, int) and not isinstance(index, bool) and index >= 0:
                self._used(parent, module, scope, value.item(index, place), depth + 1)

    def _attribute(
        self, parent: ast.Attribute, module: Module, scope: Scope | None, value: PlainValue, depth: int
    ) -> None:
        call = self.parent(parent)
        place = module.place(parent)
        if not isinstance(call, ast.Call) or call.func is not parent:
            value.is_object = True
            if isinstance(parent.ctx, ast.Load):
                self._used(parent, module, scope, value.attribute(parent.attr, place), depth + 1)
        elif parent.attr in _TEXT_METHODS:
            value.is_text = True
            value.is_bytes |= parent.attr == "decode"
            self._used(call, module, scope, value, depth)
        elif parent.attr in ("startswith", "endswith"):
            value.is_text = True
            for content in self._flow.constants(call.args[0], module, scope) if call.args else ():
                texts = content if isinstance(content, tuple) else (content,)
                value.heads |= {text: place for text in texts if isinstance(text, str)}
        elif parent.attr in _TEXT_ONLY:
            value.is_text = True
            words = PlainValue(place)
            self._used(call, module, scope, words, depth + 1)
            value.texts |= sentences(words)
            value.rest = max(value.rest, words_after(words) if parent.attr == "split" else (), key=len)
        elif parent.attr in ("get", "pop", "setdefault") and call.args:
            for name in self._flow.constants(call.args[0], module, scope):
                if isinstance(name, str):
                    content = value.key(name, place)
                    if len(call.args) > 1:
                        self.write(call.args[1], module, scope, content, is_default=True)
                    self._used(call, module, scope, content, depth + 1)
        elif parent.attr not in (*_DICT_ONLY, "copy", "get"):
            value.is_object = True

    def _assigned(self, target: ast.expr, module: Module, scope: Scope | None, value: PlainValue, depth: int) -> None:
        if isinstance(target, ast.Name):
            if scope is None:
                self.read_global(target.id, module, value, depth)
            else:
                self._named(target.id, scope, value, depth)
        elif isinstance(target, ast.Tuple | ast.List):
            for number, part in enumerate(target.elts):
                if isinstance(part, ast.Starred):
                    break
                item = value.item(number, module.place(part))
                name = dotted_name(part).rpartition(".")[2]
                value.names.setdefault(number, name)
                item.is_number |= bool(unit_of(name))
                self._assigned(part, module, scope, item, depth)
        elif isinstance(target, ast.Attribute):
            owner = self._flow.owner_of(target.value, module, scope)
            for where, at, node in self._flow.nodes if owner is not None else ():
                if not isinstance(node, ast.Attribute) or not isinstance(node.ctx, ast.Load):
                    continue
                if node.attr == target.attr and self._flow.owner_of(node.value, where, at) is owner:
                    self._used(node, where, at, value, depth + 1)

    def _argument(
        self, call: ast.Call, node: ast.AST, module: Module, scope: Scope | None, value: PlainValue, depth: int
    ) -> None:
        name = imported_name(module, call.func)
        last = name.rpartition(".")[2] or (call.func.attr if isinstance(call.func, ast.Attribute) else "")
        if name in ("json.loads", "orjson.loads", "ujson.loads"):
            value.is_json = True
            self._used(call, module, scope, value, depth)
        elif last == "isinstance" and len(call.args) == 2:
            kinds = [dotted_name(part) for part in getattr(call.args[1], "elts", [call.args[1]])]
            value.is_text |= kinds == ["str"]
        elif name in ("struct.unpack", "struct.unpack_from", "int.from_bytes"):
            value.is_bytes = True
        elif name == "type":  # what is looked up by its class is an instance of one
            value.is_object |= bool(self._flow.handled)
        elif last in ("wait_for", "shield", "cast", "dict", "list", "tuple", "str", "bool"):
            value.is_text |= last == "str"
            self._used(call, module, scope, value, depth)
        elif last == "get" and isinstance(call.func, ast.Attribute):
            for table in self._flow.constants(call.func.value, module, scope):
                pairs = getattr(table, "pairs", ())
                value.texts |= {key: module.place(node) for key, _ in pairs if isinstance(key, str)}
        elif last in _NUMBER_CALLS:
            value.is_number = True
            self._used(call, module, scope, value, depth)
        for method in self._flow.methods.get(last, ()):
            assert not isinstance(method.node, ast.ClassDef)
            value.is_object |= is_single_dispatch(method)
            for parameter in parameter_names(method.node):
                if argument_of(call, method.node, parameter, is_method=method.owner is not None) is node:
                    value.is_number |= bool(unit_of(parameter))
                    self._named(parameter, method, value, depth)

    # --- what a value is made of

    def write(
        self, expression: ast.AST, module: Module, scope: Scope | None, value: PlainValue, is_default: bool = False
    ) -> None:
        """Add what an expression can be. Of a default (`message.get("x", 0)`) the kind alone counts."""
        for node, where, at in self._flow.expressions(expression, module, scope):
            place = where.place(node) if hasattr(node, "lineno") else value.place
            if isinstance(node, ast.Dict):
                for key, content in zip(node.keys, node.values, strict=True):
                    if key is None:  # `{**others, "key": 1}`
                        self.write(content, where, at, value)
                    for name in self._flow.constants(key, where, at) if key is not None else ():
                        if isinstance(name, str):
                            self.write(content, where, at, value.key(name, place))
            elif isinstance(node, ast.Tuple | ast.List) and node.elts:
                for number, content in enumerate(node.elts):
                    if not isinstance(content, ast.Starred):
                        item = value.item(number, place)
                        is_named = isinstance(content, ast.Name | ast.Attribute)
                        value.names.setdefault(number, dotted_name(content).rpartition(".")[2] if is_named else "")
                        self.write(content, where, at, item)
            elif isinstance(node, ast.JoinedStr):
                value.is_text = True
            elif isinstance(node, ast.Compare | ast.BoolOp) or (
                isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not)
            ):
                value.is_bool = True
            elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitOr):  # of dicts, mostly
                self.write(node.left, where, at, value)
                self.write(node.right, where, at, value)
            elif isinstance(node, ast.BinOp | ast.UnaryOp):
                value.is_number = True
            elif isinstance(node, ast.Call):
                self._made_by(node, where, at, value)
            elif isinstance(node, ast.Name) and at is not None:
                self._named_arguments(node.id, at, value)
        for content, place in self._flow.constants(expression, module, scope).items():
            if isinstance(content, bool):
                value.is_bool = True
            elif isinstance(content, int | float):
                value.is_number = True
            elif isinstance(content, str | bytes):
                value.is_text = True
                if content and not is_default:
                    text = content if isinstance(content, str) else content.decode(errors="replace")
                    value.texts.setdefault(text, place)
            elif isinstance(content, Member):
                value.texts.setdefault(content.text, place)

    def _named_arguments(self, name: str, scope: Scope, value: PlainValue) -> None:
        """`**fields` of a function has a key for each argument that it is called with and that is none of its own."""
        function = scope.node
        if isinstance(function, ast.ClassDef) or function.args.kwarg is None or function.args.kwarg.arg != name:
            return
        own = parameter_names(function)
        for call in self._flow.calls.get(function.name, ()):
            for keyword in call.node.keywords:
                if keyword.arg is not None and keyword.arg not in own:
                    place = call.module.place(keyword.value)
                    self.write(keyword.value, call.module, call.scope, value.key(keyword.arg, place))

    def _made_by(self, node: ast.Call, module: Module, scope: Scope | None, value: PlainValue) -> None:
        name = imported_name(module, node.func)
        last = name.rpartition(".")[2]
        if last == "dict":
            for content in node.args[:1]:
                self.write(content, module, scope, value)
            for keyword in node.keywords:
                if keyword.arg:
                    self.write(keyword.value, module, scope, value.key(keyword.arg, module.place(node)))
        elif name in ("json.dumps", "orjson.dumps", "ujson.dumps") and node.args:
            value.is_json = True
            self.write(node.args[0], module, scope, value)
        elif last in (*_NUMBER_CALLS, *_CLOCKS, "uniform", "randint", "len"):
            value.is_number = True
        elif last in ("str", "format", "join", "upper", "lower"):
            value.is_text = True
        else:
            own = self._sources.class_of(module, node.func)
            value.is_object |= own is not None
