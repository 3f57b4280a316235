"""docs/ros2.md with the real `rclpy`, where there is one: it is not on PyPI."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from tests.docs.page import DOCS

pytestmark = pytest.mark.skipif(find_spec("rclpy") is None, reason="needs rclpy, of a ROS 2 distribution")


def test_the_example_prints_what_the_page_shows(tmp_path: Path) -> None:
    text = (DOCS / "ros2.md").read_text(encoding="utf-8")
    script, shown = text.split("```python\n")[1].split("```", 1)
    expected = shown.split("$ python talker_and_listener.py\n")[1].split("```")[0]
    file = tmp_path / "talker_and_listener.py"
    file.write_text(script)
    for seed in ("0", "7"):
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        done = subprocess.run([sys.executable, str(file)], capture_output=True, text=True, env=environment, check=False)
        assert (done.stdout, done.stderr) == (expected, "")
