"""The picture of the architecture is made from the imports, and is that of the present code."""

from __future__ import annotations

import subprocess
import sys
from itertools import pairwise

from studies import architecture
from studies.architecture import boxes, imports, levels, package_of, reduced

DIAMOND = {
    "top": frozenset({"left", "right", "bottom"}),
    "left": frozenset({"bottom"}),
    "right": frozenset({"bottom"}),
    "bottom": frozenset[str](),
}


def test_a_package_stands_above_all_that_it_imports() -> None:
    assert levels(DIAMOND) == {"bottom": 0, "left": 1, "right": 1, "top": 2}
    placed = boxes(DIAMOND)
    assert placed["top"].top < placed["left"].top == placed["right"].top < placed["bottom"].top


def test_boxes_do_not_overlap() -> None:
    placed = sorted(boxes(imports()).values(), key=lambda box: (box.top, box.left))
    for box, following in pairwise(placed):
        assert following.top > box.top or following.left > box.left + box.width
        assert 0 < box.left < box.left + box.width < architecture._WIDTH


def test_an_arrow_that_follows_from_others_is_left_out() -> None:
    assert reduced(DIAMOND)["top"] == {"left", "right"}
    assert reduced(DIAMOND)["left"] == {"bottom"}


def test_modules_stand_under_their_package() -> None:
    assert package_of("pytest_hricdv.extra.mutation.view") == "extra/mutation"
    assert package_of("pytest_hricdv.report.html") == "report"
    assert package_of("pytest_hricdv.ros2") == package_of("pytest_hricdv") == package_of("pytest_hricdv.extra") == ""
    assert package_of("sim.world") == "sim"


def test_the_picture_is_that_of_the_code() -> None:
    """Drawn in a process of its own: here, another test may have imported another package of these names."""
    picture = architecture.PICTURE.read_text(encoding="utf-8")
    code = "from studies.architecture import drawn, imports; print(drawn(imports()), end='')"
    made = subprocess.run([sys.executable, "-c", code], cwd=architecture.ROOT, stdout=subprocess.PIPE, check=True)
    assert picture == made.stdout.decode(), "packages import each other otherwise now: python -m studies.architecture"
