"""Views of a report: report files, terminal, HTML page, JUnit properties, and files for other tools.

Plain functions over the types of `pytest_hricdv.results.model`: a report of another day or machine is shown the same
way as that of the session.
"""
