"""The documentation site: what Sphinx needs beside docs/conf.py to build it from pages that GitHub shows as they are.

- `pages`: Markdown as it stands in the repository, to Markdown as Sphinx reads it
- `agentspeak`: colours of AgentSpeak and of project files
- `docstrings`: sections of docstrings to field lists
- `public_names`: what has to have a place on an API page
- `scorer.js`: how the search ranks pages
- `extension`: connects these with Sphinx
"""
