"""`TraceResult`: the record of a run's MCAP files in `report.json`; `SceneChange`: a change of the scene in a file.

`TraceWriter` makes both; `TracesFeature` puts the former into the result of a test as its section `TRACE`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from msgspec import Meta
from msgspec.structs import replace

from pytest_hricdv._base.record import PlainRecord
from pytest_hricdv.results.section import FileNames, TestSection

if TYPE_CHECKING:
    from pytest_hricdv.runtime.world import Body

FOLDER = "traces"
"""The report's folder with the traces."""


McapName = Annotated[str, Meta(pattern=r"^traces/[A-Za-z0-9._-]+\.mcap\Z")]
"""The path of a file, relative to the report. It becomes a link on the page, so it can lead nowhere else."""


class TraceResult(PlainRecord, frozen=True, kw_only=True):
    """The MCAP file of a run, relative to the report; `note` says why it is missing or faulty.

    `bag` is a second one, with the messages of ROS 2 as `ros2 bag` has them; None if there are none.
    """

    file: McapName | None
    note: str = ""
    bag: McapName | None = None


@dataclass(frozen=True)
class SceneChange:
    """What changed in the scene: the bodies that are new, or elsewhere, and the names of those that are gone."""

    time_us: int
    moved: tuple[Body, ...]
    gone: tuple[str, ...]


def _rename(trace: TraceResult | None, names: FileNames) -> TraceResult | None:
    return trace and replace(trace, file=names.file(FOLDER, trace.file), bag=names.file(FOLDER, trace.bag))


TRACE: TestSection[TraceResult | None] = TestSection(
    "trace", TraceResult | None, None, rename=_rename, folder=FOLDER, suffixes=(".mcap",)
)
"""The trace of a test whose run was to be written."""

TEST_SECTIONS = (TRACE,)
