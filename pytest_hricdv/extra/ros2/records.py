"""What a report has of the ROS 2 system of a run."""

from __future__ import annotations

from pytest_hricdv._base.record import Names
from pytest_hricdv.results.section import TestSection

NOTES: TestSection[Names] = TestSection("ros2_notes", Names, ())
"""What is to be known of the graph of a run, though it fails nothing, a sentence each: qualities of service that do not
match, with both ends."""

TEST_SECTIONS = (NOTES,)
