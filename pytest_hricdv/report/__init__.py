"""Views of a report: report files, terminal, HTML page, JUnit properties, and files for other tools.

Plain functions over the types of `pytest_hricdv.results.model`: a report of another day or machine is shown the same
way as that of the session.
"""

EXPORT_FORMATS = {
    "cobertura": "write the coverage of the code under test as Cobertura XML",
    "lcov": "write the coverage of the code under test as an LCOV tracefile",
    "ucis": "write the coverage of code, plans, requirements and cross products as UCIS XML",
    "summary": "write the summary of the session as markdown",
}
"""Format of an exported file, and the name of its option -> help."""
