"""Static checks of BDI models: probable mistakes in models that can be loaded and run.

Example::

    from pytest_hricdv.bdi.lint import lint

    for finding in lint(["models_bdi/table_assembly.mas2j"]):
        print(finding)

A remark ``// lint: ignore NAME reason`` in the same line or in a comment line just above ignores a finding. Percepts
are declared by ``// lint: percepts name, ...``.
"""

from __future__ import annotations

from pytest_hricdv.bdi.lint.runner import CHECKS, Check, Finding, lint

__all__ = ["CHECKS", "Check", "Finding", "lint"]
