"""How Sphinx builds the site from the pages in this folder: `make docs`."""

import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))  # for studies.site, and for the plugin as it is in this checkout

_PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]

project = _PROJECT["name"]
author = "The pytest-hricdv developers"
copyright = author
repository_url = _PROJECT["urls"]["Source"]

extensions = ["myst_parser", "sphinx.ext.autodoc", "studies.site.extension"]
exclude_patterns = ["_build"]

myst_heading_anchors = 4  # links to sections, with the anchors that GitHub makes
suppress_warnings = ["myst.xref_ambiguous"]

# API pages. In docstrings single backquotes are code; a name is a link where the site has it.
default_role = "prose"
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_default_options = {"members": True}
python_maximum_signature_line_length = 88
add_module_names = False

html_theme = "furo"
html_title = f"{project} {_PROJECT['version']}"
html_static_path = ["_static"]
html_search_scorer = str(ROOT / "studies" / "site" / "scorer.js")
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False
html_show_copyright = False
smartquotes_action = "D"  # dashes of field lists; quotes stay as they are written
