"""What a user does wrong is said on a line, with what to do, and nothing is lost."""

from __future__ import annotations

import socket
import sqlite3
from pathlib import Path

import pytest

from pytest_hricdv.extra.campaign.plan import CampaignError
from pytest_hricdv.extra.campaign.store import Store
from tests.extra.campaign.conftest import RUN, SUITE, Campaign
from tests.plugin import project


def free_port() -> int:
    """A port that nobody listens to."""
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["run", "--suite=nonesuch"], "the tests cannot be planned: ERROR: --hri-suite: suite 'nonesuch' is not a"),
        (["run", "--concretizations=0"], "'0': expected a whole number from 1 to 10,000,000"),
        (["run", "--cluster=lokal"], "'lokal': expected local, local:WORKERS or a scheduler's tcp://HOST:PORT"),
        (["run", "--cluster=local:0"], "expected at least one worker"),
        (["run", "--audit=101"], "expected a share in per cent, from 0 to 100"),
        (
            ["run", *SUITE, "--", "--hri-schedules=5"],
            "--hri-schedules: it follows the last test of a session, and a campaign only runs tests; give it to pytest",
        ),
        (["run", *SUITE, "--state=nowhere/a.db"], "there is no folder"),
        (["status"], "campaign.db: no such campaign: 'hricdv campaign run --state="),
        (["report", "--state=conftest.py"], "conftest.py: damaged, or not a campaign (file is not a database)"),
        (["run", *SUITE, "--state=conftest.py"], "conftest.py: damaged, or not a campaign (file is not a database)"),
        (["export", "--state=a.db"], "the following arguments are required: --parquet"),
    ],
)
def test_it_is_said_on_a_line(campaign: Campaign, arguments: list[str], said: str) -> None:
    done = campaign(*arguments)
    assert done.returncode == 2
    assert said in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.slow
def test_a_scheduler_that_is_not_there(lamps: Path, campaign: Campaign) -> None:
    project.change(lamps, "pytest.ini", "hri_audit = off", "hri_audit = off\nhri_schedules = 3")
    address = f"tcp://127.0.0.1:{free_port()}"
    done = campaign("run", *SUITE, f"--cluster={address}", "--state=a.db")
    assert done.returncode == 3
    assert "left out: schedules (--hri-schedules): it follows the last test of a session" in done.stdout
    assert f"{address}: no scheduler answers there" in done.stdout
    assert "start one with 'dask scheduler'" in done.stdout
    assert "expected 4, stored 0" in done.stdout
    assert "Traceback" not in done.stderr + done.stdout
    nothing = campaign("report", "--state=a.db")
    assert (nothing.returncode, "no run is stored yet" in nothing.stderr) == (2, True)


@pytest.mark.slow
def test_a_damaged_store_is_not_touched(begun: Path, lamps: Path, campaign: Campaign) -> None:
    data = (lamps / "a.db").read_bytes()
    (lamps / "a.db").write_bytes(data[: len(data) // 2])
    for arguments in (["status"], ["report"], ["run", *SUITE, "--cluster=local:1"]):
        done = campaign(*arguments, "--state=a.db")
        assert done.returncode == 2, done.stdout
        assert "a.db: damaged, or not a campaign" in done.stderr
    assert (lamps / "a.db").read_bytes() == data[: len(data) // 2]


def test_another_database_is_no_campaign(lamps: Path, campaign: Campaign) -> None:
    with sqlite3.connect(lamps / "b.db") as connection:
        connection.execute("CREATE TABLE campaign (name TEXT, value BLOB)")
    connection.close()
    assert "expected a campaign of schema hricdv-campaign/4, found None" in campaign("status", "--state=b.db").stderr


@pytest.mark.slow
def test_a_campaign_that_runs_is_not_run_twice(begun: Path, lamps: Path, campaign: Campaign) -> None:
    holder = Store.open(lamps / "a.db")
    holder.hold()
    refused = campaign(*RUN)
    holder.close()
    assert refused.returncode == 2
    assert "this campaign is running already (process " in refused.stderr


@pytest.mark.slow
def test_a_full_disk_is_said_and_loses_nothing(begun: Path, lamps: Path, campaign: Campaign) -> None:
    store = Store.open(lamps / "a.db")
    [(key, result, replay)] = store.results([(0, 0)])
    store._connection.execute("PRAGMA max_page_count = 1")
    worker = store.workers()[1]

    def fill() -> None:
        for k in range(5, 1000):
            store.add((key[0], k), result, replay, worker)

    with pytest.raises(CampaignError, match=r"a\.db: cannot be read or written: database or disk is full; what was"):
        fill()
    store.close()
    assert "expected 20, stored" in campaign("status", "--state=a.db").stdout
