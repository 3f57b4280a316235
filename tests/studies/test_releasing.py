"""A release is made only where tag, version and changelog agree; and what it ships is the plugin, whole."""

from __future__ import annotations

import re
import subprocess
import sys
import zipfile
from email.parser import Parser
from pathlib import Path

import pytest

from studies.releasing import ROOT, ReleaseError, main, notes

CHANGELOG = "# Changelog\n\n## 0.2.0 (2027-01-31)\n\n- New.\n\n## 0.1.0 (2026-12-01)\n\n- Old.\n"


@pytest.fixture
def root(tmp_path: Path) -> Path:
    (tmp_path / "pyproject.toml").write_text('[project]\nversion = "0.2.0"\n', encoding="utf-8")
    (tmp_path / "CHANGELOG.md").write_text(CHANGELOG, encoding="utf-8")
    return tmp_path


def test_the_notes_are_the_section_of_the_version(root: Path) -> None:
    assert notes("v0.2.0", root) == "- New."


def test_a_tag_of_another_version_is_refused(root: Path) -> None:
    with pytest.raises(ReleaseError, match=r"the tag has to be 'v0\.2\.0'; it is 'v0\.3\.0'"):
        notes("v0.3.0", root)


@pytest.mark.parametrize("heading", ["## 0.2.0 (unreleased)", "## 0.1.9 (2027-01-31)", "no heading"])
def test_a_changelog_that_is_not_ready_is_refused(root: Path, heading: str) -> None:
    (root / "CHANGELOG.md").write_text(f"# Changelog\n\n{heading}\n\n- New.\n", encoding="utf-8")
    with pytest.raises(ReleaseError, match=r"CHANGELOG\.md: .* expected '## 0\.2\.0 \(YYYY-MM-DD\)'"):
        notes("v0.2.0", root)


def test_the_command_says_what_is_wrong(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["v999.0"]) == 1
    assert capsys.readouterr().err.startswith("pyproject.toml: version is ")


@pytest.mark.slow
def test_wheel_and_sdist_are_whole(tmp_path: Path) -> None:
    """All of the plugin's files, data included, and nothing beside it; made and checked as by `make dist`."""
    python("-m", "build", "--outdir", str(tmp_path))
    files = [str(path) for path in tmp_path.iterdir()]
    assert len(files) == 2
    python("-m", "twine", "check", "--strict", *files)
    (wheel,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        about = next(name for name in names if name.endswith(".dist-info/METADATA")).removesuffix("METADATA")
        metadata = Parser().parsestr(archive.read(f"{about}METADATA").decode())
        entry_points = archive.read(f"{about}entry_points.txt").decode()
    tracked = git("ls-files", "--cached", "--others", "--exclude-standard", "pytest_hricdv").splitlines()
    assert {name for name in names if not name.startswith(about)} == {
        name for name in tracked if (ROOT / name).exists()
    }
    assert {f"{about}licenses/{name}" for name in metadata.get_all("License-File", [])} <= {*names}
    assert sorted(entry_points.split("\n\n")) == [
        "[console_scripts]\nhricdv = pytest_hricdv.__main__:run",
        "[pytest11]\nhricdv = pytest_hricdv.plugin\n",
    ]
    links = re.findall(r"\]\(([^)]+)\)", str(metadata.get_payload()))
    assert len(links) > 20
    assert [link for link in links if not link.startswith("https://")] == [], "on PyPI these lead nowhere"


def python(*arguments: str) -> None:
    done = subprocess.run([sys.executable, *arguments], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def git(*arguments: str) -> str:
    return subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=True).stdout
