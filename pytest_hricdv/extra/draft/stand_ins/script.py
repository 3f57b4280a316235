"""A program as the robot: its module is executed anew in each run."""

from __future__ import annotations

import ast
import sys
from dataclasses import dataclass
from importlib.util import find_spec, module_from_spec


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
