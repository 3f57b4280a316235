"""Messages within messages: what a person says has them, and its manners vary them."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from pytest_hricdv.extra.draft.analysis import analyse
from pytest_hricdv.extra.draft.questions import questions
from pytest_hricdv.extra.draft.writing.drafted import Draft
from pytest_hricdv.extra.draft.writing.project import files, write

WARD = """
from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Settings:
    patience_s: float = 9.0


@dataclass(frozen=True)
class Stop:
    room: str
    floor: int = 0


@dataclass(frozen=True)
class Item:
    label: str
    cold: bool = False


@dataclass(frozen=True)
class Order:
    number: int
    to: Stop
    by: Stop | None = None
    items: list[Item] = field(default_factory=list)
    within: tuple[Order, ...] = ()


@dataclass(frozen=True)
class Done:
    number: int


class Ward:
    def __init__(self, bus, settings: Settings = Settings()):
        self.bus, self.settings = bus, settings
        self.orders = bus.subscribe(Order)

    def run(self):
        while (order := self.orders.wait(self.settings.patience_s)) is not None:
            if order.to.room == "store" and order.to.floor > 2:
                continue
            if any(item.cold for item in order.items):
                self.bus.publish(Done(0))
            self.bus.publish(Done(order.number))
"""


def drafted(folder: Path) -> Draft:
    (folder / "ward.py").write_text(WARD, encoding="utf-8")
    return Draft(analyse("ward", folder), "ward", "person", folder.resolve() / "hri")


def test_what_is_within_a_message_is_made_too_and_what_may_be_missing_is_left_out_at_times(tmp_path: Path) -> None:
    text = dict(files(drafted(tmp_path)))["conftest.py"]
    said = [line for line in text.splitlines() if "return Order(" in line]
    assert all("to=Stop(room=" in line for line in said)
    assert any("by=None" in line for line in said)
    assert any("by=Stop(room=" in line for line in said)
    assert any("items=[]" in line for line in said)
    assert any("items=[Item(label=" in line and "cold=True)]" in line for line in said)


def test_a_text_within_a_message_of_which_nothing_is_known_is_a_question_with_its_path(tmp_path: Path) -> None:
    assert any("`order.items.label`" in question.text for question in questions(drafted(tmp_path).findings))


def test_its_draft_passes_ruff_and_imports_nothing_that_it_does_not_use(tmp_path: Path) -> None:
    draft = drafted(tmp_path)
    write(draft, draft.folder)
    command = [sys.executable, "-m", "ruff", "check", "--isolated", "--select", "I,F", "."]
    checked = subprocess.run(command, cwd=draft.folder, capture_output=True, text=True, check=False)
    assert checked.returncode == 0, checked.stdout
