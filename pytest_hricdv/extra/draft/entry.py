"""What is to be called to run the code, and what it has to be handed."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass, replace

from pytest_hricdv._base.suggestion import nearest
from pytest_hricdv.extra.draft.constants import is_enum
from pytest_hricdv.extra.draft.findings import Entry, Operation, Port
from pytest_hricdv.extra.draft.messages import QUEUES, SAYS, SUBSCRIBES, form_of
from pytest_hricdv.extra.draft.naming import unit_of
from pytest_hricdv.extra.draft.neutral import neutral
from pytest_hricdv.extra.draft.sources import DraftError, Function, Module, Scope, Sources, dotted_name, imported_name
from pytest_hricdv.extra.draft.value_flow import ValueFlow, argument_of, default_of, parameter_names

METHODS = ("run", "work", "serve", "main", "live", "loop", "main_loop", "run_forever", "spin", "execute", "start",
           "control", "step", "tick", "update")  # fmt: skip
"""Methods of a robot's class that make it work, the likeliest first."""

FUNCTIONS = (
    "main",
    "run",
    "work",
    "serve",
    "robot",
    "control",
    "loop",
    "start",
    "spin",
    "amain",
    "main_loop",
    "worker",
    "control_loop",
    "event_loop",
)
"""Functions that make a robot work."""

QUEUE = {"get", "put", "get_nowait", "put_nowait", "empty", "qsize", "task_done", "join", "full"}
CLOCK = {"sleep", "now_s", "now", "time", "monotonic"}
MAX_DEPTH = 6
"""So often a port may be handed on (chosen)."""


@dataclass(frozen=True)
class Candidate:
    """Something that may be the entry, and how likely."""

    score: float
    scope: Scope
    method: Scope | None


class EntryFinder:
    """Finds the entry, and reads its ports."""

    def __init__(self, sources: Sources, flow: ValueFlow) -> None:
        self._sources, self._flow = sources, flow

    def entry(self, name: str) -> Entry | None:
        """The entry; None where there is nothing to call.

        Args:
            name: of a function, class, or `Class.method`; empty for the likeliest one.

        Raises:
            DraftError: there is no such function.
        """
        candidates = sorted(self._candidates(), key=lambda candidate: -candidate.score)
        if name:
            return self._read(self._named(name), "certain")
        if not candidates or candidates[0].score <= 0:
            return None
        is_sure = len(candidates) == 1 or candidates[0].score >= candidates[1].score + 2
        return self._read(candidates[0], "certain" if is_sure else "likely")

    def _named(self, name: str) -> Candidate:
        head, _, method = name.partition(".")
        scopes = [scope for scope in (*self._sources.functions, *self._sources.classes)
                  if scope.node.name == head and scope.owner is None]  # fmt: skip
        if not scopes:
            there = [
                scope.node.name for scope in (*self._sources.functions, *self._sources.classes) if scope.owner is None
            ]
            raise DraftError(
                f"--from={self._sources.package}:{name}: no function or class {head!r}{nearest(head, there)}"
            )
        scope = scopes[0]
        if not isinstance(scope.node, ast.ClassDef):
            return Candidate(0.0, scope, None)
        methods = self._methods(scope)
        if method and method not in methods:
            raise DraftError(
                f"--from={self._sources.package}:{name}: {head} has no method {method!r}{nearest(method, methods)}"
            )
        chosen = method or next((name for name in METHODS if name in methods), "")
        return Candidate(0.0, scope, methods.get(chosen))

    def _methods(self, scope: Scope) -> dict[str, Scope]:
        assert isinstance(scope.node, ast.ClassDef)
        methods: dict[str, Scope] = {}
        for base in reversed(scope.node.bases):
            own = self._sources.class_of(scope.module, base)
            if own is not None and own.node is not scope.node:
                methods |= self._methods(own)
        for statement in scope.node.body:
            if isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef):
                methods[statement.name] = Scope(scope.module, statement, scope.node)
        return methods

    def _candidates(self) -> Iterator[Candidate]:
        for scope in self._sources.functions:
            function = scope.node
            assert not isinstance(function, ast.ClassDef)
            is_top = scope.owner is None and function in scope.module.tree.body
            if is_top and not function.name.startswith("_"):
                score = self._score(scope, function) + (2 if function.name in FUNCTIONS else -2)
                yield Candidate(score, scope, None)
        for scope in self._sources.classes:
            assert isinstance(scope.node, ast.ClassDef)
            bases = {base.rpartition(".")[2] for base in self._sources.bases(scope)}
            if is_enum(self._sources, scope) or bases & {"Protocol", "ABC", "Exception", "NamedTuple", "TypedDict"}:
                continue
            methods = self._methods(scope)
            chosen = next((name for name in METHODS if name in methods), "")
            if form_of(self._sources, scope) and not chosen:
                continue
            begin = methods.get("__init__")
            score = 1.0 if chosen else -1.0
            score += 1.0 if methods.get("__init__") is not None else 0.0
            for method in methods.values():
                assert not isinstance(method.node, ast.ClassDef)
                score += 0.5 * min(self._speaks(method.node), 2)
            score += self._from_outside(scope) + (0 if begin is None else self._port_score(begin))
            score += 3.5 * self._makes_queue(scope.node)
            yield Candidate(score, scope, methods.get(chosen))

    def _score(self, scope: Scope, function: Function) -> float:
        return self._from_outside(scope) + self._port_score(scope) + min(self._speaks(function), 2)

    def _port_score(self, scope: Scope) -> float:
        assert not isinstance(scope.node, ast.ClassDef)
        names = [name for name in parameter_names(scope.node) if name != "self"]
        roles = [self._port(scope, name).role for name in names]
        return 3.0 * any(role in ("bus", "publish", "queue", "reader") for role in roles)

    def _makes_queue(self, owner: ast.ClassDef) -> bool:
        """Whether a class makes a queue of its own that it takes from: what puts into it is outside of the robot."""
        for (name, attribute), assigned in self._flow.attributes.items():
            for where, value in assigned if name == owner.name else ():
                if isinstance(value, ast.Call) and imported_name(where.module, value.func) in QUEUES:
                    calls = [*self._flow.calls.get("get", ()), *self._flow.calls.get("get_nowait", ())]
                    takes = [dotted_name(call.node.func) for call in calls]
                    if any(taken.startswith(f"self.{attribute}.") for taken in takes):
                        return True
        return False

    def _from_outside(self, scope: Scope) -> float:
        """More where nothing of the code calls it, most where its main program does."""
        calls = [
            call
            for call in self._flow.calls.get(scope.node.name, ())
            if call.scope is None or call.scope.node is not scope.node
        ]
        score = 1.5 if not calls else -1.0
        if any(call.scope is None for call in calls):
            score = 2.5
        if scope.module.name.rpartition(".")[2] in (
            "main",
            "__main__",
            "robot",
            "app",
            "node",
            "controller",
            scope.node.name.lower(),
        ):
            score += 0.5
        return score

    def _speaks(self, function: Function) -> int:
        return sum(
            isinstance(node, ast.Call) and _last(node.func).strip("_") in (*SAYS, *SUBSCRIBES)
            for node in ast.walk(function)
        )

    def _read(self, candidate: Candidate, certainty: str) -> Entry:
        scope, method = candidate.scope, candidate.method
        if not isinstance(scope.node, ast.ClassDef):
            is_async = isinstance(scope.node, ast.AsyncFunctionDef)
            ports = tuple(self._ports(scope))
            return Entry(scope.module.name, scope.node.name, "", is_async, ports, (), scope.place,
                         "certain" if certainty == "certain" else "likely")  # fmt: skip
        begin = self._methods(scope).get("__init__")
        ports = tuple(self._ports(begin, skip=1)) if begin is not None else tuple(self._fields(scope))
        method_ports = tuple(self._ports(method, skip=1)) if method is not None else ()
        parts = [method] if method is not None else self._methods(scope).values()  # it is called back, if at all
        is_async = any(isinstance(part.node, ast.AsyncFunctionDef) for part in parts)
        name = method.node.name if method is not None else ""
        return Entry(scope.module.name, scope.node.name, name, is_async, ports, method_ports, scope.place,
                     "certain" if certainty == "certain" else "likely")  # fmt: skip

    def _ports(self, scope: Scope, skip: int = 0) -> Iterator[Port]:
        assert not isinstance(scope.node, ast.ClassDef)
        for name in parameter_names(scope.node)[skip:]:
            yield self._port(scope, name)

    def _fields(self, scope: Scope) -> Iterator[Port]:
        """Of a dataclass, its fields are the parameters."""
        assert isinstance(scope.node, ast.ClassDef)
        if form_of(self._sources, scope) != "dataclass":
            return
        for statement in scope.node.body:
            if isinstance(statement, ast.AnnAssign) and isinstance(statement.target, ast.Name):
                name, default = statement.target.id, ast.unparse(statement.value) if statement.value else ""
                operations = tuple(self._of_attribute(scope.node, name, 0))
                written = ast.unparse(statement.annotation)
                role = self._role(name, written, default, operations, scope.module)
                made = neutral(self._sources, scope.module, statement.annotation) or ("", ())
                place = scope.module.place(statement)
                yield Port(name, role, written, default, operations, place, _side(operations), False, *made)

    def _port(self, scope: Scope, name: str) -> Port:
        function = scope.node
        assert not isinstance(function, ast.ClassDef)
        part = next(
            p for p in (*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs) if p.arg == name
        )
        written = ast.unparse(part.annotation).strip("'\"") if part.annotation is not None else ""
        default = default_of(function, name)
        text = ast.unparse(default) if default is not None else ""
        unique: dict[str, Operation] = {}
        for operation in self._operations(scope, name, 0):
            unique[operation.name] = _merged(unique.get(operation.name), operation)
        operations = tuple(self._typed(operation, part.annotation, scope.module) for operation in unique.values())
        role = self._role(name, written, text, operations, scope.module)
        keyword = part in function.args.kwonlyargs
        made = neutral(self._sources, scope.module, part.annotation) or ("", ())
        return Port(name, role, written, text, operations, scope.module.place(part), _side(operations), keyword, *made)

    def _typed(self, operation: Operation, annotation: ast.expr | None, module: Module) -> Operation:
        """The same with what the class of the annotation says that it returns."""
        own = self._sources.class_of(module, annotation)
        if own is None or not isinstance(own.node, ast.ClassDef):
            return operation
        for statement in own.node.body:
            if isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef) and statement.name == operation.name:
                returns = ast.unparse(statement.returns) if statement.returns is not None else operation.returns
                is_async = isinstance(statement, ast.AsyncFunctionDef) or operation.is_async
                is_property = any(_last(decorator) == "property" for decorator in statement.decorator_list)
                kind = "attribute" if is_property else operation.kind
                names = tuple(parameter_names(statement)[1:])
                place = own.module.place(statement)
                is_read = kind == "attribute"
                made = neutral(self._sources, own.module, statement.returns)
                text, needs = made or ("", ())
                return Operation(operation.name, "attribute" if is_read else "method", names, returns, place, is_async,
                                 compared=operation.compared, made=text, needs=needs)  # fmt: skip
            if isinstance(statement, ast.AnnAssign) and dotted_name(statement.target) == operation.name:
                returns, place = ast.unparse(statement.annotation), own.module.place(statement)
                return Operation(operation.name, "attribute", (), returns, place,
                                 is_set=operation.is_set)  # fmt: skip
        return operation

    def _role(self, name: str, written: str, default: str, operations: tuple[Operation, ...], module: Module) -> str:
        used = {operation.name for operation in operations}
        if "Queue" in written or (used and used <= QUEUE and used & {"get", "put", "get_nowait", "put_nowait"}):
            return "queue"
        if "StreamReader" in written or used & {"readline", "readexactly", "readuntil"}:
            return "reader"
        if "StreamWriter" in written or (used and used <= {"write", "drain", "close", "wait_closed", "is_closing"}):
            return "writer"
        if used & {"publish", "subscribe", "emit"}:
            return "bus"
        if used == {"__call__"} and any(
            word in name for word in ("publish", "send", "say", "emit", "on_", "notify", "report")
        ):
            return "publish"
        if (used and used <= CLOCK) or name == "clock":
            return "clock"
        if used & {"__call__"} and name in ("sleep", "now", "clock", "time"):
            return "clock"
        own = self._sources.class_of(module, _parsed(written))
        if own is not None and form_of(self._sources, own) in ("dataclass", "model", "namedtuple"):
            return "settings"
        if own is not None and is_enum(self._sources, own):
            return "parameter"
        if written in ("int", "float", "str", "bool") or unit_of(name) or (default and not used):
            return "parameter"
        return "device" if used or written or name in ("robot", "arm", "base", "gripper", "driver") else "parameter"

    # --- what is done with a port

    def _operations(self, scope: Scope, name: str, depth: int) -> Iterator[Operation]:
        """What a function does with a parameter, and those do that it hands it on to."""
        if depth > MAX_DEPTH:
            return
        for node in ast.walk(scope.node):
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == name:
                yield self._operation(node, scope.module)
            elif isinstance(node, ast.Call):
                if isinstance(node.func, ast.Name) and node.func.id == name:
                    yield Operation("__call__", "method", (), "", scope.module.place(node))
                yield from self._handed_on(node, scope, name, depth)
            elif isinstance(node, ast.Assign | ast.AnnAssign) and scope.owner is not None:
                for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
                    pairs = [(target, node.value)]
                    if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
                        pairs = list(zip(target.elts, node.value.elts, strict=False))
                    for part, value in pairs:
                        if isinstance(value, ast.Name) and value.id == name and dotted_name(part).startswith("self."):
                            yield from self._of_attribute(scope.owner, dotted_name(part)[5:], depth + 1)

    def _handed_on(self, node: ast.Call, scope: Scope, name: str, depth: int) -> Iterator[Operation]:
        arguments = [*node.args, *(keyword.value for keyword in node.keywords)]
        if not any(isinstance(argument, ast.Name) and argument.id == name for argument in arguments):
            return
        for callee in self._callees(node, scope):
            assert not isinstance(callee.node, ast.ClassDef)
            for parameter in parameter_names(callee.node):
                value = argument_of(node, callee.node, parameter, is_method=callee.owner is not None)
                if isinstance(value, ast.Name) and value.id == name:
                    yield from self._operations(callee, parameter, depth + 1)

    def _callees(self, node: ast.Call, scope: Scope) -> list[Scope]:
        own = self._sources.class_of(scope.module, node.func)
        if own is not None:
            begin = self._methods(own).get("__init__")
            return [begin] if begin is not None else []
        methods = self._flow.methods.get(_last(node.func), [])
        return methods if len(methods) == 1 else [method for method in methods if method.owner is scope.owner]

    def _of_attribute(self, owner: ast.ClassDef, attribute: str, depth: int) -> Iterator[Operation]:
        """What is done with an attribute of a class."""
        if depth > MAX_DEPTH:
            return
        for module, scope, node in self._flow.nodes:
            if scope is None:
                continue
            if isinstance(node, ast.Attribute) and self._is_attribute(node.value, owner, attribute, scope):
                yield self._operation(node, module)
            elif isinstance(node, ast.Call):
                if self._is_attribute(node.func, owner, attribute, scope):
                    yield Operation("__call__", "method", (), "", module.place(node))
                for callee in self._callees(node, scope) if node.args or node.keywords else ():
                    assert not isinstance(callee.node, ast.ClassDef)
                    for parameter in parameter_names(callee.node):
                        value = argument_of(node, callee.node, parameter, is_method=callee.owner is not None)
                        if value is not None and self._is_attribute(value, owner, attribute, scope):
                            yield from self._operations(callee, parameter, depth + 1)

    def _is_attribute(self, node: ast.expr, owner: ast.ClassDef, attribute: str, scope: Scope) -> bool:
        return (
            isinstance(node, ast.Attribute)
            and node.attr == attribute
            and self._flow.owner_of(node.value, scope.module, scope) is owner
        )

    def _operation(self, node: ast.Attribute, module: Module) -> Operation:
        parent = self._parents.get(id(node))
        place = module.place(node)
        if isinstance(parent, ast.Call) and parent.func is node:
            names = [_last(argument) or f"argument_{number}" for number, argument in enumerate(parent.args)]
            names = [name if names.count(name) == 1 else f"{name}_{number}" for number, name in enumerate(names)]
            names += [keyword.arg for keyword in parent.keywords if keyword.arg]
            above = self._parents.get(id(parent))
            is_async = isinstance(above, ast.Await)
            returns = self._used_as(above if is_async and above is not None else parent, node.attr)
            value = above if is_async and above is not None else parent
            compared = self._compared(value, module)
            return Operation(node.attr, "method", tuple(names), returns, place, is_async, compared=compared)
        is_set = isinstance(node.ctx, ast.Store)
        compared, returns = self._compared(node, module), self._used_as(node, node.attr)
        return Operation(node.attr, "attribute", (), returns, place, is_set=is_set, compared=compared)

    def _compared(self, node: ast.AST, module: Module) -> tuple[float, ...]:
        """The numbers that a value is compared with where it stands."""
        parent = self._parents.get(id(node))
        if not isinstance(parent, ast.Compare):
            return ()
        scope = next((at for _, at, other in self._flow.nodes if other is parent), None)
        parts = [part for part in (parent.left, *parent.comparators) if part is not node]
        values = [value for part in parts for value in self._flow.constants(part, module, scope)]
        return tuple(float(v) for v in values if isinstance(v, int | float) and not isinstance(v, bool))

    def _used_as(self, node: ast.AST, name: str) -> str:
        """The kind of a value, by its use: "bool", "float", "text"; empty where it says none."""
        parent = self._parents.get(id(node))
        if isinstance(parent, ast.Compare):
            others = [part for part in (parent.left, *parent.comparators) if part is not node]
            if any(isinstance(part, ast.Constant) and isinstance(part.value, str) for part in others):
                return "text"
            if any(isinstance(part, ast.Constant) and part.value is None for part in others):
                return ""
            return "float"
        if isinstance(parent, ast.BinOp | ast.AugAssign) or (
            isinstance(parent, ast.UnaryOp) and isinstance(parent.op, ast.USub)
        ):
            return "float"
        if isinstance(parent, ast.If | ast.While | ast.IfExp | ast.BoolOp | ast.UnaryOp | ast.Assert):
            return "bool"
        if isinstance(parent, ast.Call) and _last(parent.func) in (
            "abs",
            "min",
            "max",
            "float",
            "round",
            "hypot",
            "sqrt",
        ):
            return "float"
        if unit_of(name):
            return "float"
        return "bool" if name.startswith(("is_", "has_")) or "_is_" in name else ""

    @property
    def _parents(self) -> dict[int, ast.AST]:
        parents: dict[int, ast.AST] | None = self.__dict__.get("_parent_of")
        if parents is None:
            parents = {id(child): node for _, _, node in self._flow.nodes for child in ast.iter_child_nodes(node)}
            self.__dict__["_parent_of"] = parents
        return parents


def _merged(before: Operation | None, operation: Operation) -> Operation:
    """Two uses of the same operation as one."""
    if before is None:
        return operation
    return replace(
        before,
        kind="method" if "method" in (before.kind, operation.kind) else "attribute",
        returns=before.returns or operation.returns,
        arguments=max(before.arguments, operation.arguments, key=len),
        is_async=before.is_async or operation.is_async,
        is_set=before.is_set or operation.is_set,
        compared=tuple(dict.fromkeys(before.compared + operation.compared)),
    )


def _parsed(text: str) -> ast.expr | None:
    try:
        return ast.parse(text, mode="eval").body if text else None
    except SyntaxError:
        return None


def _side(operations: tuple[Operation, ...]) -> str:
    used = {operation.name for operation in operations}
    heard, said = bool(used & {"get", "get_nowait"}), bool(used & {"put", "put_nowait"})
    return "heard" if heard and not said else "said" if said and not heard else ""


def _last(node: ast.AST) -> str:
    return node.attr if isinstance(node, ast.Attribute) else node.id if isinstance(node, ast.Name) else ""
