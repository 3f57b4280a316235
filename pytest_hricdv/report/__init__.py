"""One report model, plain JSON-able data, and its views: files, terminal, HTML page, JUnit properties.

Everything here reads the dict that `report.json` holds (see `contract.schema`); nothing here knows the rest of the
plugin, so a report of yesterday or of another machine is shown the same way.
"""

from pytest_hricdv.report.contract import SCHEMA, faults, schema
from pytest_hricdv.report.files import ReportError, load, prepare, write
from pytest_hricdv.report.junit import properties
from pytest_hricdv.report.line import Line, Style
from pytest_hricdv.report.terminal import failure, header, summary

__all__ = [
    "SCHEMA",
    "Line",
    "ReportError",
    "Style",
    "failure",
    "faults",
    "header",
    "load",
    "prepare",
    "properties",
    "schema",
    "summary",
    "write",
]
