"""Suites are the same bytes in every process, and a replay loads no BDI engine."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.generate.table import ROOT
from tests.generate.toy import lamps

GENERATE = """
import sys
from dataclasses import replace
from pathlib import Path
from pytest_hricdv.generate.concrete import concretize
from pytest_hricdv.generate.methods import METHODS
from tests.generate.table import CONCRETIZATION, CONTEXT
from tests.generate.toy import LAMPS, lamps

suite = METHODS[sys.argv[1]].generate(replace(CONTEXT, model=lamps(Path(sys.argv[2])), space=LAMPS, seed=7))
print(suite.to_json())
if sys.argv[1] == "pseudorandom":
    for test in suite.tests:
        print(concretize(test, CONCRETIZATION).to_json())
"""


def _python(code: str, *arguments: str, hash_seed: str = "0") -> str:
    environment = {**os.environ, "PYTHONHASHSEED": hash_seed, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-c", code, *arguments]
    return subprocess.run(command, env=environment, check=True, capture_output=True, text=True, timeout=60).stdout


@pytest.mark.parametrize("method", ["rl", "bdi-random", "pseudorandom"])
def test_the_same_seed_gives_the_same_bytes_in_every_process(method: str, tmp_path: Path) -> None:
    lamps(tmp_path)
    one = _python(GENERATE, method, str(tmp_path), hash_seed="1")
    assert one == _python(GENERATE, method, str(tmp_path), hash_seed="4321")
    assert len(one) > 1000
