"""Errors of the command line, of the ini file, and of the files that these name."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv._base.message import legible


def usage_error(text: str) -> pytest.UsageError:
    """The error that pytest prints as it is, ending with status 4; legible, whatever the text quotes."""
    return pytest.UsageError(legible(text))


def located(error: BaseException) -> str:
    """An error with its deepest place outside of this plugin and of installed packages."""
    trace, place = error.__traceback__, ""
    while trace is not None:
        code = trace.tb_frame.f_code
        file = Path(code.co_filename)
        if "site-packages" not in file.parts and _PACKAGE not in file.parents and not code.co_filename.startswith("<"):
            place = f"{file}:{trace.tb_lineno}: {code.co_name}: "
        trace = trace.tb_next
    return f"{place}{type(error).__name__}: {error}"


_PACKAGE = Path(__file__).parents[1]
