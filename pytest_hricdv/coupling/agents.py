"""Reads agents of a model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from pytest_hricdv._base.suggestion import nearest
from pytest_hricdv.bdi import BdiError
from pytest_hricdv.bdi.language.project import read_project
from pytest_hricdv.bdi.run.system import AgentTemplate, read_templates
from pytest_hricdv.coupling.hears import CouplingError
from pytest_hricdv.generate.model import Model


def read_agents(wanted: Sequence[str], model: Model) -> tuple[tuple[AgentTemplate, ...], tuple[str, ...]]:
    """The agents of these names, and the names of all others, whose sources are not read: they can be large.

    Raises:
        CouplingError: there is no such agent, or the model cannot be read.
    """
    try:
        project = read_project(model.path)
        entries = {entry.name: entry for entry in project.agents}
        for name in wanted:
            if name not in entries:
                raise CouplingError(f"no agent {name!r} in {model.path}{nearest(name, entries)}")
        agents = read_templates(replace(project, agents=tuple(entries[name] for name in wanted)))
    except (BdiError, OSError) as error:
        raise CouplingError(f"BDI model {model.path}: {error}") from error
    return agents, tuple(name for name in entries if name not in wanted)
