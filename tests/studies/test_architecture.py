"""The picture of the architecture is made from the imports, and is that of the present code."""

from __future__ import annotations

import subprocess
import sys

from studies import architecture


def test_the_picture_is_that_of_the_code() -> None:
    """Drawn in a process of its own: here, another test may have imported another package of these names."""
    picture = architecture.PICTURE.read_text(encoding="utf-8")
    code = "from studies.architecture import drawn, imports; print(drawn(imports()), end='')"
    made = subprocess.run([sys.executable, "-c", code], cwd=architecture.ROOT, stdout=subprocess.PIPE, check=True)
    assert picture == made.stdout.decode(), "packages import each other otherwise now: python -m studies.architecture"
