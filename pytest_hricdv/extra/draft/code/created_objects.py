"""Finds, in the source, what the code creates itself and a stand-in has to replace; `CodeReader` calls it.

That is: objects and modules of libraries that are missing or fail, sockets and servers, and other programs. What the
code gets from outside is in `ports`.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from dataclasses import replace

from pytest_hricdv.extra.draft.code.flow import Flow, last_name
from pytest_hricdv.extra.draft.code.handovers import connection_of
from pytest_hricdv.extra.draft.code.ports import PortReader
from pytest_hricdv.extra.draft.code.sources import Module, Scope, Sources, name_with_dots, resolve_import
from pytest_hricdv.extra.draft.code_model import SCRIPT, Entry, Port

SOCKETS = ("socket.socket", "socket.create_connection", "socket.create_server", "asyncio.start_server",
           "asyncio.open_connection")  # fmt: skip
"""Calls that open a connection to the outside."""

PROGRAMS = ("subprocess.run", "subprocess.call", "subprocess.check_call", "subprocess.check_output", "subprocess.Popen",
            "subprocess.getoutput", "subprocess.getstatusoutput", "os.system", "os.popen", "urllib.request.urlopen",
            "urllib.request.urlretrieve", "http.client.HTTPConnection", "http.client.HTTPSConnection", "requests.get",
            "requests.post", "requests.put", "requests.patch", "requests.delete", "requests.head", "requests.request",
            "requests.Session")  # fmt: skip
"""Calls that start another program, or request from a server."""


class CreatedObjects:
    """Finds what the code creates itself, as ports."""

    def __init__(self, sources: Sources, flow: Flow) -> None:
        self._sources, self._flow = sources, flow

    def ports(self, entry: Entry, faulty: frozenset[str]) -> Iterator[Port]:
        """The ports that stand-ins replace, each name and `made_from` once; `faulty` is that of `CodeReader.model`."""
        done: set[str] = set()
        scope = self._sources.class_named(entry.module, entry.name)
        every = (*self._attributes(scope, faulty), *self._modules(faulty), *self._sockets(entry, scope))
        for port in (*every, *self._programs()):
            if not done & {port.name, port.made_from}:
                done |= {port.name, port.made_from}
                yield port

    def _attributes(self, scope: Scope | None, faulty: frozenset[str]) -> Iterator[Port]:
        ports = PortReader(self._sources, self._flow)
        done: set[str] = set()
        for (owner, name), assigned in self._flow.attributes.items() if scope is not None else ():
            assert scope is not None
            for where, value in assigned if owner == id(scope.node) and name not in done else ():
                if not isinstance(value, ast.Call) or not name_with_dots(value.func):
                    continue
                top = resolve_import(where.module, value.func).partition(".")[0]
                own = self._sources.class_of(where.module, value.func)
                if top in faulty or (own is not None and f".{own.node.name}" in faulty):
                    target = f"{where.module.name}:{name_with_dots(value.func)}"
                    done.add(name)
                    port = ports.attribute(scope, name, target, value)
                    yield port if port.role in ("bus", "device") else replace(port, role="device")

    def _modules(self, faulty: frozenset[str]) -> Iterator[Port]:
        """Modules whose functions the code calls: `GPIO.input(4)`."""
        ports = PortReader(self._sources, self._flow)
        for module in self._sources.modules:
            for name, dotted in module.imports.items():
                if dotted.partition(".")[0] in faulty:
                    port = ports.variable(module, name, module.tree)
                    functions = tuple(
                        operation for operation in port.operations if operation.is_method and operation.name.islower()
                    )
                    if functions:
                        made_from = f"{module.name}:{name}"
                        yield replace(port, role="device", operations=functions, made_from=made_from,
                                      location=functions[0].location)  # fmt: skip

    def _sockets(self, entry: Entry, own: Scope | None) -> Iterator[Port]:
        """Connections that the entry, or a class whose objects it creates, opens under whatever name."""
        ports = PortReader(self._sources, self._flow)
        owners = [own.node] if own is not None else []
        for (owner, _), assigned in self._flow.attributes.items() if own is not None else ():
            made = [self._sources.class_of(where.module, getattr(value, "func", None)) for where, value in assigned]
            owners += [scope.node for scope in made if scope is not None and owner == id(owners[0])]
        for module, scope, node in self._flow.nodes:
            if entry.is_class and (scope is None or scope.owner not in owners):
                continue
            if not isinstance(node, ast.Call):
                continue
            origin = resolve_import(module, node.func)
            if origin not in SOCKETS and not self._is_server(module, node):
                continue
            above = self._flow.parents.get(id(node))
            above = self._flow.parents.get(id(above)) if isinstance(above, ast.Await) else above
            name = name_with_dots(above.targets[0]) if isinstance(above, ast.Assign) else self._connection_name(node)
            made_from = f"{module.name}:{name_with_dots(node.func)}"
            if entry.name == SCRIPT and origin not in SOCKETS:  # each run imports it anew
                made_from = ":".join(origin.rsplit(".", 1))
            yield replace(ports.variable(module, name or "connection", node), role="connection", made_from=made_from)

    def _is_server(self, module: Module, node: ast.Call) -> bool:
        """Whether a library's function is passed one of the code that serves a connection: `serve(handler, port)`."""
        top, _, name = resolve_import(module, node.func).partition(".")
        is_imported = name_with_dots(node.func).partition(".")[0] in module.imports
        return bool(name) and is_imported and top not in sys.stdlib_module_names and bool(self._connection_name(node))

    def _connection_name(self, node: ast.Call) -> str:
        """Name of the parameter by which a function among the arguments gets a connection; empty if there is none."""
        functions = (function for part in node.args for function in self._flow.methods.get(last_name(part), ())
                     if function.owner is None or name_with_dots(part).startswith("self."))  # fmt: skip
        return next((name for function in functions for name in [connection_of(self._flow, function)] if name), "")

    def _programs(self) -> Iterator[Port]:
        """Functions that start other programs or request from servers, once for each module that calls them."""
        for module, _, node in self._flow.nodes:
            dotted = resolve_import(module, node.func) if isinstance(node, ast.Call) else ""
            if dotted in PROGRAMS and isinstance(node, ast.Call):
                target, location = f"{module.name}:{name_with_dots(node.func)}", module.location(node)
                yield Port(target, "program", dotted, "", (), location, made_from=target)
