"""The process that plans a campaign: it lets pytest collect the tests, and sends them to its parent.

`plan.make_plan` starts it with a `PlanningJob`, a line of JSON. Its own pytest plugin sends the tests, as JSON, too.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import msgspec
import pytest

from pytest_hricdv._base.project_files import identity
from pytest_hricdv.results.codec import encode
from pytest_hricdv.results.report_builder import declare_report
from pytest_hricdv.session.child_process import END, NO_REWRITE_WARNING, channel
from pytest_hricdv.session.feature import features
from pytest_hricdv.session.run_context import CONTEXT, RunContext

_WITHOUT = ("--collect-only", "-q", "-n0", *NO_REWRITE_WARNING)


@dataclass(frozen=True)
class PlanningJob:
    """The line that the process receives: the arguments of pytest."""

    arguments: tuple[str, ...]


class _Planner:
    """A pytest plugin that sends back the collected tests."""

    def __init__(self, job: PlanningJob, write: Callable[[bytes], None]) -> None:
        self._job = job
        self._write = write

    @pytest.hookimpl(trylast=True)
    def pytest_collection_finish(self, session: pytest.Session) -> None:
        """Sends the tests, and everything that does not depend on their results."""
        manager = session.config.pluginmanager
        aggregation = manager.get_plugin("hricdv-aggregation")
        reporting = manager.get_plugin("hricdv-reporting")
        assert aggregation is not None, "this is not an xdist worker"
        assert reporting is not None, "this is not an xdist worker"
        declared = declare_report(reporting.session_info(), {})
        here = identity(Path(session.config.rootpath), session.config.stash[CONTEXT].provenance.code)
        self._write(
            msgspec.json.encode(
                {
                    "arguments": self._job.arguments,
                    "root": str(session.config.invocation_params.dir),
                    "rootdir": os.path.relpath(session.config.rootpath, session.config.invocation_params.dir),
                    "tests": [
                        {"suite": case.suite, "nodeid": nodeid, "data": case.abstract.to_data()}
                        for nodeid, case in aggregation.chosen.items()
                    ],
                    "project": here.project,
                    "versions": here.versions,
                    "left_out": tuple(_follow_ups(session.config.stash[CONTEXT])),
                    "declared": msgspec.Raw(encode(declared).encode()),
                }
            )
        )
        self._write(END)


def _follow_ups(context: RunContext) -> Iterator[str]:
    """Work that is asked for after the last test of a session. A campaign has an audit of its own."""
    return (name for feature in features() if feature.name != "audit" and (name := feature.follow_up(context)))


def main() -> None:
    """Plan: the line of standard input is a `PlanningJob`."""
    with channel() as (messages, write), tempfile.TemporaryDirectory() as folder:
        job = msgspec.json.decode(messages.readline(), type=PlanningJob)
        arguments = [*job.arguments, f"--hri-report={folder}", *_WITHOUT]
        status = pytest.main(arguments, plugins=[_Planner(job, write)])
    sys.exit(int(status))


if __name__ == "__main__":
    main()
