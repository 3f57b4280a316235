"""Pictures that are older than what they show are named."""

from __future__ import annotations

from pathlib import Path

from studies import freshness


def project(root: Path) -> Path:
    for name in ("docs/pictures/report.png", "docs/pictures/run.gif", "pytest_hricdv/report/page.css", "sim/arm.py"):
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text("as it was")
    freshness.made(["report.png", "run.gif"], root)
    return root


def test_a_picture_is_outdated_once_what_it_shows_has_changed(tmp_path: Path) -> None:
    root = project(tmp_path)
    assert freshness.outdated(root) == []
    (root / "pytest_hricdv/report/page.css").write_text("as it is")
    assert freshness.outdated(root) == ["report.png"]
    (root / "sim/leg.py").write_text("a new file")
    assert freshness.outdated(root) == ["report.png", "run.gif"]
    freshness.made(["run.gif"], root)
    assert freshness.outdated(root) == ["report.png"]


def test_a_picture_that_is_gone_is_forgotten(tmp_path: Path) -> None:
    root = project(tmp_path)
    (root / "docs/pictures/report.png").unlink()
    freshness.made(["run.gif"], root)
    assert set(freshness.stamps(root)) == {"run.gif"}
