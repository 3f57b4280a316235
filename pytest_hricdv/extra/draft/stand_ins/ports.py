"""What a drafted testbench gives a port in each run: a clock, a parameter of the run, a new object, or a replacement.

If the robot is a program, its module is executed again in each run (`Script`). Modules that are not installed, such as
libraries of the robot's hardware, get stand-ins (`replace_modules`).
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import find_spec, module_from_spec
from inspect import isfunction
from types import ModuleType
from typing import Any, Protocol

from pytest_hricdv.extra.draft.stand_ins.border import RunBorder
from pytest_hricdv.extra.draft.stand_ins.neutral import Neutral
from pytest_hricdv.extra.draft.stand_ins.parts import OutsidePart, exception_type, is_caught, part_of_module


class RobotPort(Protocol):
    """A stand-in that each run makes for itself."""

    def make(self, border: RunBorder, name: str) -> Any:
        """The stand-in of a run, for the port of this name."""


@dataclass(frozen=True)
class ClockPort:
    """A port that tells the time or waits: an object with `sleep` and `now_s`, or one of these functions.

    Args:
        form: "object", "now" (a function that returns the time in s) or "sleep" (one that waits).
    """

    form: str = "object"

    def make(self, border: RunBorder, name: str) -> Any:
        """The clock of a run."""
        kernel = border.run.kernel
        return {"object": kernel, "now": lambda: kernel.now_s, "sleep": kernel.sleep}[self.form]


@dataclass(frozen=True)
class RunParameter:
    """A number that is drawn for each run: a parameter of `Concretization.run`.

    Args:
        name: the name of the parameter.
        is_whole: whether it is an integer.
    """

    name: str
    is_whole: bool = False

    def make(self, border: RunBorder, name: str) -> Any:
        """The number of this run."""
        number = border.run.test.run[self.name]
        return round(number) if self.is_whole else number


@dataclass(frozen=True)
class Make:
    """A port that gets what a function makes, new in each run."""

    function: Callable[[], Any]

    def make(self, border: RunBorder, name: str) -> Any:
        """The object that it makes."""
        return self.function()


@dataclass(frozen=True)
class ProgramPort:
    """Another program that the code starts, but no run does: its arguments and results cross the border.

    Args:
        path: the path of the function that starts it, as "subprocess.run".
    """

    path: str

    def make(self, border: RunBorder, name: str) -> OutsidePart:
        """The function of a run."""
        return OutsidePart(self.path)


@dataclass(frozen=True)
class Replace:
    """An object that the code makes itself: a run replaces what it is made from.

    Args:
        target: module and name, as "robot.arm:mqtt.Client", or of an object of the module itself.
        port: the stand-in.
    """

    target: str
    port: RobotPort

    def apply(self, border: RunBorder, name: str) -> Callable[[], None]:
        """Replace it; returns what puts it back."""
        module, _, path = self.target.partition(":")
        *owners, last = path.split(".")
        owner: Any = import_module(module)
        made = self.port.make(border, name)
        if owners and getattr(owner, owners[0], None) is None:
            return lambda: None  # the code does without it
        for number, name_of_inner in enumerate(owners):
            inner = getattr(owner, name_of_inner)
            if isinstance(inner, ModuleType) and number == len(owners) - 1:  # others use the module, too
                maker = made if _is_itself(made) else _Maker(getattr(inner, last), made)
                setattr(owner, name_of_inner, _ModuleWith(inner, last, maker))
                return partial(setattr, owner, name_of_inner, inner)
            owner = inner
        before = getattr(owner, last)
        setattr(owner, last, _Maker(before, made) if callable(before) and not _is_itself(made) else made)
        return partial(setattr, owner, last, before)


def _is_itself(made: Any) -> bool:
    """Whether the stand-in is called itself; others are what a call makes."""
    return isfunction(made) or type(made) is OutsidePart


class _ModuleWith(ModuleType):
    """A module as one of its users sees it: with another object under one name."""

    def __init__(self, module: ModuleType, name: str, made: Any) -> None:
        super().__init__(module.__name__)
        self.__dict__.update({name: made, "_module": module})

    def __getattr__(self, name: str) -> Any:
        return getattr(self.__dict__["_module"], name)


class _Maker:
    """A fake of a class: makes the stand-in, and has the constants of the class."""

    def __init__(self, kind: Any, made: Any) -> None:
        self._kind, self._made = kind, made

    def __call__(self, *_: Any, **__: Any) -> Any:
        return self._made

    def __getattr__(self, name: str) -> Any:
        return getattr(self._kind, name, Neutral())


@dataclass(frozen=True)
class Script:
    """A module whose statements run the robot, as `python MODULE.py` does; for `Driver.robot`.

    It keeps its name, by which virtual time and coverage know it; only its own `__name__` is "__main__".

    Args:
        module: its dotted name.
    """

    module: str

    def __call__(self) -> None:
        """Execute it.

        Raises:
            ModuleNotFoundError: there is no such module.
        """
        spec = find_spec(self.module)
        if spec is None or spec.origin is None:
            raise ModuleNotFoundError(f"no module {self.module!r}", name=self.module)
        with open(spec.origin, "rb") as file:
            tree = ast.parse(file.read(), spec.origin)
        code = compile(_AsMain().visit(tree), spec.origin, "exec")
        module = module_from_spec(spec)
        before, sys.modules[self.module] = sys.modules.get(self.module), module
        try:
            exec(code, vars(module))
        finally:
            if before is not None:
                sys.modules[self.module] = before
            else:
                sys.modules.pop(self.module, None)


class _AsMain(ast.NodeTransformer):
    """Replaces `__name__` by the name of a program."""

    def visit_Name(self, node: ast.Name) -> ast.expr:
        """Replace a name."""
        is_read = node.id == "__name__" and isinstance(node.ctx, ast.Load)
        return ast.copy_location(ast.Constant("__main__"), node) if is_read else node


# --- modules that are not installed


class _AbsentModule(ModuleType):
    """A module that is not installed."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.__path__ = []  # so that it has submodules

    def __getattr__(self, name: str) -> Any:
        # It is kept: `except` needs the class that was raised.
        make = exception_type if is_caught(sys._getframe(1)) else part_of_module
        self.__dict__[name] = found = make(self.__name__.rpartition(".")[2], name)
        return found


class _AbsentFinder(MetaPathFinder, Loader):
    """Finds the modules that are not installed."""

    def __init__(self, names: frozenset[str]) -> None:
        self.names = names

    def find_spec(self, fullname: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        """Find these modules, and those in them."""
        is_absent = any(f"{fullname}.".startswith(f"{name}.") for name in self.names)
        return ModuleSpec(fullname, self, is_package=True) if is_absent else None

    def create_module(self, spec: ModuleSpec) -> _AbsentModule:
        """A stand-in."""
        return _AbsentModule(spec.name)

    def exec_module(self, module: ModuleType) -> None:
        """There is nothing to execute."""


def replace_modules(*names: str) -> None:
    """Let code be imported without modules that are not installed: each gets a stand-in."""
    if not any(isinstance(finder, _AbsentFinder) and finder.names == {*names} for finder in sys.meta_path):
        sys.meta_path.insert(0, _AbsentFinder(frozenset(names)))
