"""What looks wrong in BDI models, though it can be loaded and run.

Example::

    from pytest_hricdv.bdi.lint import lint

    for finding in lint(["models_bdi/table_assembly.mas2j"]):
        print(finding)

A finding that is meant to be can be justified in the source, in its line or in a comment line of its own
just above: ``// lint: ignore NAME why``. What an agent perceives is declared by ``// lint: percepts name, ...``.
"""

from __future__ import annotations

from .checks import CHECKS
from .finding import Check, Finding
from .runner import lint

__all__ = ["CHECKS", "Check", "Finding", "lint"]
