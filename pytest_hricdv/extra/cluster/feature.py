"""A cluster in a session: its options. What runs tests on it are the closing loop and searches."""

from __future__ import annotations

from dataclasses import dataclass

from pytest_hricdv.session.feature import Feature
from pytest_hricdv.session.option import Flag, OptionReader, Repeatable, Value


@dataclass(frozen=True)
class ClusterOptions:
    """On which cluster the closing loop and a search run tests.

    Args:
        address: as `pytest_hricdv.extra.cluster.address` reads it; empty: on none.
        send_code: the project is sent to the workers, which do not have it.
        send_hidden: patterns of its hidden files that are sent as well.
    """

    address: str = ""
    send_code: bool = False
    send_hidden: tuple[str, ...] = ()


class ClusterFeature(Feature[ClusterOptions]):
    """Workers of Dask distributed."""

    name = "cluster"
    options = (
        Value(
            "cluster",
            "ADDRESS",
            "let the closing loop and --hri-search run tests on workers of Dask distributed: tls://HOST:8786, the "
            "address of a scheduler, or local:N, with N workers on this machine",
        ),
        Flag("send-code", "send the project to the workers of --hri-cluster, which otherwise have it at the same path"),
        Repeatable(
            "send-hidden",
            "PATTERN",
            "with --hri-send-code, send hidden files with this name, as .robot.toml, too",
            "hidden files that --hri-send-code sends, too: a name or a pattern a line",
        ),
    )

    def read(self, reader: OptionReader) -> ClusterOptions:
        """The cluster that is named."""
        return ClusterOptions(reader.text("cluster"), reader.flag("send_code"), reader.texts("send_hidden"))


FEATURE = ClusterFeature()
