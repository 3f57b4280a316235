"""Each command of README and the pages runs: where its page is followed, here, or in the tests of what it needs."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.docs.page import DOCS, run

ROOT = DOCS.parent
PAGES = [ROOT / "README.md", *sorted(path for path in DOCS.rglob("*.md") if not {"studies", "_build"} & {*path.parts})]
_FENCED = re.compile(r"^```(\w+)[^\n]*\n(.*?)^```", re.MULTILINE | re.DOTALL)
_PLAIN = re.compile(r"^    ((?:pytest|hricdv|python|pip|make)\b.*)$", re.MULTILINE)
_FENCED_KINDS = ("sh", "bash")

FOLLOWED = {
    "README.md": "test_readme.py",
    "tutorial.md": "test_tutorial.py",
    "vacuum.md": "test_pages.py",
    "bring-your-code.md": "test_pages.py",
    "own-world.md": "test_pages.py",
    "people.md": "test_pages.py",
    "install.md": "test_pages.py",
    "ros2.md": "../extra/ros2/test_rclpy.py",
    "jason-support.md": "../bdi/test_docs.py",
    "writing-models.md": "../bdi/test_docs.py",
}
"""Pages whose `console` blocks a test follows."""

ELSEWHERE = {
    "pip install": "test_pages.py",
    "python -m venv": "test_pages.py",
    "hricdv init hri --ros2": "../extra/draft/test_ros_draft.py",
    "hricdv init hri --from my_package --recording monday.mcap": "../extra/draft/test_recorded.py",
    "python $(which colcon)": "../extra/ros2/test_workspace.py",
    "hricdv report rebuild": "../plugin/test_journal.py",
    "hricdv evidence": "../extra/evidence/test_evidence.py",
    "hricdv report live": "../extra/answers/test_live.py",  # runs until Ctrl-C
}
"""Commands that need more than a project -> the tests that run them, or what they do, with the real thing."""

PLACES = {
    "FILE...": "models/coffee.mas2j",
    "FILE.mas2j": "models/coffee.mas2j",
    "FOLDER": "models",
    "yourpackage": "my_package",
}
"""What stands for something of the reader's -> what it is in the project below."""

SMALL = (
    ("--concretizations=41", "--concretizations=2"),
    ("--hri-schedules=100", "--hri-schedules=3"),
    ("--hri-mutate", "--hri-mutate --hri-mutate-faults=2"),
    ("--from my_package", "--from my_package --budget=5"),
    ("hricdv suggest", "hricdv suggest --faults=2 --further=2"),
)
"""Options that only decide how long a command takes."""

CODE = '''"""A robot that greets who comes in."""

import queue
from dataclasses import dataclass


@dataclass
class Visitor:
    """Somebody came in."""

    name: str


class Greeter:
    """Says hello to each visitor."""

    def __init__(self, visitors: "queue.Queue[Visitor]") -> None:
        self.visitors = visitors
        self.greeted = 0

    def run(self) -> None:
        """Greets until nobody comes any more."""
        while True:
            self.visitors.get()
            self.greeted += 1
'''

DEMO = """import queue
import threading

from my_package import Greeter, Visitor

visitors = queue.Queue()
threading.Thread(target=Greeter(visitors).run, daemon=True).start()
visitors.put(Visitor("Ada"))
"""


def plain_commands(page: Path) -> Iterator[str]:
    """The commands of a page outside of its `console` blocks, without comments."""
    text = page.read_text(encoding="utf-8")
    fenced = [found[2] for found in _FENCED.finditer(text) if found[1] in _FENCED_KINDS]
    for line in [*"".join(fenced).splitlines(), *_PLAIN.findall(_FENCED.sub("", text))]:
        for part in re.split(r"&&|;", re.sub(r"\s+#.*", "", line)):
            if part.strip() and not part.strip().startswith(("cd ", ". ", "#")):
                yield part.strip()


def test_each_page_with_a_console_is_followed() -> None:
    pages = {page.name for page in PAGES if any(found[1] == "console" for found in _FENCED.finditer(page.read_text()))}
    assert pages == set(FOLLOWED)
    assert all((Path(__file__).parent / name).is_file() for name in (*FOLLOWED.values(), *ELSEWHERE.values()))


def commands_here(page: Path) -> list[str]:
    """The commands that are run in the project below; what follows on one that is run elsewhere is run there, too."""
    found = [*plain_commands(page)]
    after = {number + 1 for number, command in enumerate(found) if command.startswith(tuple(ELSEWHERE))}
    return [
        command
        for number, command in enumerate(found)
        if not command.startswith(tuple(ELSEWHERE)) and not (number in after and command == "pytest")
    ]


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The tutorial's project, and a package of code."""
    folder = tmp_path_factory.mktemp("pages")
    assert run("hricdv init coffee", folder)[0] == 0
    (folder / "my_package").mkdir()
    (folder / "my_package" / "__init__.py").write_text(CODE, encoding="utf-8")
    (folder / "my_package" / "demo.py").write_text(DEMO, encoding="utf-8")
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("page", [page for page in PAGES if commands_here(page)], ids=lambda page: page.stem)
def test_commands_run(page: Path, project: Path) -> None:
    for command in commands_here(page):
        text = command
        for place, stands_for in (*PLACES.items(), *SMALL):
            text = text.replace(place, stands_for)
        if text == "hricdv init coffee":
            continue  # the project's own beginning
        needs_code = "my_package" in text
        folder = project if needs_code else project / "hri" if page.stem == "draft" else project / "coffee"
        status, printed = run(text, folder)
        assert status == 0, f"$ {text}\n{printed}"
