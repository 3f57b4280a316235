"""`look`: the progress of a running campaign and its report so far; `hricdv report live` calls it repeatedly."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

from pytest_hricdv.extra.campaign.commands import MAX_LISTED
from pytest_hricdv.extra.campaign.plan import CampaignError
from pytest_hricdv.extra.campaign.reporting import campaign_report
from pytest_hricdv.extra.campaign.store import Store
from pytest_hricdv.results.codec import ReportError


def look(path: Path, scratch: Path) -> Mapping[str, Any]:
    """The fields of a live state.

    Args:
        scratch: a folder for replay files.

    Raises:
        ReportError: it cannot be read.
    """
    try:
        with closing(Store.open(path.resolve())) as store:
            plan, counts = store.plan(), store.counts()
            report = campaign_report(store, plan, MAX_LISTED, scratch)[0] if counts.runs else None
            workers, cancelled = len(store.workers()), store.is_cancelled
    except CampaignError as error:
        raise ReportError(str(error)) from None
    return {
        "what": "campaign",
        "is_over": counts.runs >= plan.runs or cancelled,
        "done": counts.runs,
        "total": plan.runs,
        "workers": workers,
        "rate_s": counts.wall_s / counts.runs if counts.runs else None,
        "report": report,
    }
