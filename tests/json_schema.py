"""The JSON Schemas that ship with the plugin, for programs that read its files."""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Any

import jsonschema


def _validator(package: str, name: str) -> jsonschema.Draft202012Validator:
    schema: dict[str, Any] = json.loads(files(package).joinpath(name).read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


REPORT = _validator("pytest_hricdv.results", "report-3.schema.json")
REPLAY = _validator("pytest_hricdv.results", "replay-2.schema.json")
