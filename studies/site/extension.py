"""What Sphinx calls while it builds the site: the parts of this package, connected with its events."""

from __future__ import annotations

from typing import TYPE_CHECKING

from docutils import nodes
from sphinx.domains.python import PyXRefRole
from sphinx.util import logging

from studies.site.agentspeak import AgentSpeakLexer, ProjectLexer
from studies.site.docstrings import field_lists
from studies.site.pages import ROOT, root_file, sphinx_source
from studies.site.public_names import docstring, home, listed

if TYPE_CHECKING:
    from docutils.nodes import Node, system_message
    from docutils.parsers.rst.states import Inliner
    from sphinx.application import Sphinx
    from sphinx.environment import BuildEnvironment
    from sphinx.util.typing import ExtensionMetadata


def setup(app: Sphinx) -> ExtensionMetadata:
    """Called by Sphinx, because docs/conf.py lists this module among the extensions."""
    app.add_lexer("asl", AgentSpeakLexer)
    app.add_lexer("mas2j", ProjectLexer)
    app.add_config_value("repository_url", "", "env", str)
    app.connect("source-read", _read)
    app.add_role("prose", _role)
    app.connect("autodoc-process-docstring", _document)
    app.connect("autodoc-process-signature", _sign)
    app.connect("env-check-consistency", _check)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}


def _read(app: Sphinx, page: str, source: list[str]) -> None:
    """Event `source-read`: a page has been read, and is not parsed yet."""
    name = root_file(page)
    if name:
        app.env.note_dependency(str(ROOT / name), docname=page)
    source[0] = sphinx_source(page, source[0], app.config.repository_url)


def _document(app: Sphinx, what: str, name: str, documented: object, options: object, lines: list[str]) -> None:
    """Event `autodoc-process-docstring`: a docstring has been read, and is not parsed yet.

    That of a value or an alias which the page's module only imports is not found by Sphinx, but by us.
    """
    module, _, last = name.rpartition(".")
    if not any(lines) and last in listed().get(module, ()):
        lines[:] = docstring(module, last).splitlines()
    lines[:] = field_lists(lines)


def _sign(
    app: Sphinx, what: str, name: str, documented: object, options: object, signature: str | None, result: str | None
) -> tuple[str | None, str | None]:
    """Event `autodoc-process-signature`: what dataclasses write for defaults that they make is no Python to Sphinx."""
    return (signature.replace("<factory>", "...") if signature else signature), result


def _role(
    role: str, source: str, text: str, line: int, inliner: Inliner, options: object = None, content: object = ()
) -> tuple[list[Node], list[system_message]]:
    """The role of single backquotes in docstrings: code; a name is linked where the site has it."""
    if not all(part.isidentifier() for part in text.split(".")):
        return [nodes.literal(source, text)], []
    return PyXRefRole()("py:obj", source, text, line, inliner)


def _check(app: Sphinx, env: BuildEnvironment) -> None:
    """Event `env-check-consistency`: all pages have been parsed. Each public name has to be on one, of any module."""
    described = env.domains.python_domain.objects
    for module, names in listed().items():
        for name in names:
            if not {f"{module}.{name}", f"{home(module, name)[0]}.{name}"} & {*described}:
                logging.getLogger(__name__).warning(f"{module}.{name} is public, and on no API page")
