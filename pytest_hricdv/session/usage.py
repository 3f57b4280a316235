"""Errors of the command line, of the ini file, and of the files that these name."""

from __future__ import annotations

import pytest

from pytest_hricdv._base.message import legible


def usage_error(text: str) -> pytest.UsageError:
    """The error that pytest prints as it is, ending with status 4; legible, whatever the text quotes."""
    return pytest.UsageError(legible(text))
