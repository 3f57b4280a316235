"""The pages name every option, and only options, pages, commands and places in the code that exist."""

from __future__ import annotations

import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from pytest_hricdv.__main__ import main
from pytest_hricdv.run import Run
from pytest_hricdv.session.option_table import all_options
from pytest_hricdv.testbench import Testbench
from studies.site.pages import OVERVIEWS, entries, listed
from tests.docs.page import DOCS

PAGES = sorted([*DOCS.rglob("*.md"), *DOCS.parent.glob("*.md")])
FIXTURES = {"hri_case", "hri_run", "hri_state"}  # the last is what --hri-break-on-violation gives to a debugger


@pytest.fixture(scope="module")
def there(tmp_path_factory: pytest.TempPathFactory) -> dict[str, set[str]]:
    """The plugin's options and ini keys; of them, those that pytest lists."""
    command = [sys.executable, "-m", "pytest", "--help"]
    text = subprocess.run(command, cwd=tmp_path_factory.mktemp("empty"), capture_output=True, text=True, check=True)
    return {
        "options": {f"--hri-{option.name}" for option in all_options()},
        "shown": set(re.findall(r"^  (--hri-[a-z-]+)", text.stdout, re.MULTILINE)),
        "keys": set(re.findall(r"^  (hri_[a-z_]+) \(", text.stdout, re.MULTILINE)),
    }


def test_pytest_shows_at_most_forty_options_and_names_those_that_refine_them(there: dict[str, set[str]]) -> None:
    assert 20 < len(there["shown"]) <= 40
    assert there["shown"] < there["options"]


def test_the_reference_has_every_option_and_key_and_its_key_beside_it(there: dict[str, set[str]]) -> None:
    assert len(there["options"]) > 20
    rows = re.findall(
        r"^\| `(--hri-[a-z-]+)[^|]*?(?:\\\|[^|]*?)*` \| (?:`(hri_[a-z_]+)`)?", _text("reference.md"), re.M
    )
    without_option = re.findall(r"^\| \| `(hri_[a-z_]+)`", _text("reference.md"), re.MULTILINE)
    assert {option for option, _ in rows} == there["options"]
    assert {key for _, key in rows if key} | {*without_option} == there["keys"]
    for option, key in rows:
        assert key in ("", "hri_" + option[6:].replace("-", "_"), "hri_known_violations")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_no_page_speaks_of_an_option_or_a_key_that_is_not_there(page: Path, there: dict[str, set[str]]) -> None:
    text = page.read_text(encoding="utf-8")
    assert set(re.findall(r"--hri-[a-z]+(?:-[a-z]+)*", text)) <= there["options"]
    assert set(re.findall(r"\bhri_[a-z]+(?:_[a-z]+)*", text)) <= there["keys"] | FIXTURES


def test_the_reference_has_every_part_of_a_testbench() -> None:
    part = _text("reference.md").partition("## Hook")[2].partition("`run` receives")[0]
    part = part.partition("Of these, `VirtualTime`")[0]
    named = re.findall(r"`(\w+)`", "".join(re.findall(r"^\| (`.*?) \|", part, re.MULTILINE)))
    assert sorted(named) == sorted(Testbench.__dataclass_fields__)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    text = re.sub(r"^```.*?^```$|`[^`\n]*`", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if "://" not in target:
            assert (page.parent / target.partition("#")[0]).exists(), target


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_commands_name_modules_that_exist(page: Path) -> None:
    for module in re.findall(
        r"python -m (benchmarks[\w.]*|studies[\w.]*|pytest_hricdv[\w.]*)", page.read_text(encoding="utf-8")
    ):
        name = module.rstrip(".")
        in_example = DOCS.parent / "examples" / "home_care" / f"{name.replace('.', '/')}.py"
        assert in_example.exists() or find_spec(name) is not None, module


def test_the_overviews_list_every_page_once() -> None:
    shown = [page for line in entries(_text("index.md")) for _, page in line]
    shown += [page for overview in OVERVIEWS for page in listed(_text(f"{overview}.md"), overview)]
    there = {page.relative_to(DOCS).with_suffix("").as_posix() for page in DOCS.rglob("*.md")} - {"index"}
    assert sorted(shown) == sorted(there)


def test_the_reference_names_each_command(capsys: pytest.CaptureFixture[str]) -> None:
    def commands(*group: str) -> set[str]:
        with pytest.raises(SystemExit):
            main([*group, "--help"])
        listed = capsys.readouterr().out.partition("\n  COMMAND\n")[2]
        return {" ".join(("hricdv", *group, name)) for name in re.findall(r"^    (\w+) ", listed, re.MULTILINE)}

    there = commands() | commands("report") | commands("model")
    assert len(there) > 20
    named = set(re.findall(r"`(hricdv (?:report |model )?\w+)", _text("reference.md")))
    assert there - {"hricdv model", "hricdv report", "hricdv model lint"} <= named


def test_the_reference_names_only_what_a_run_has() -> None:
    part = _text("reference.md").partition("| `run.` | |")[2].partition("\n\n")[0]
    named = set(re.findall(r"`(\w+)(?:\([^`]*\))?`", "".join(re.findall(r"^\| (`.*?) \|", part, re.MULTILINE))))
    assert len(named) > 10
    assert named - {*dir(Run), *Run.__dataclass_fields__} == set()


def _text(page: str) -> str:
    return (DOCS / page).read_text(encoding="utf-8")
