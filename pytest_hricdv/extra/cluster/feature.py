"""A cluster in a session (`--hri-cluster`): `ClusterFeature` has its options.

The closing loop, searches and campaigns get workers from `DaskCluster`, by `session.remote.remote`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path

import pytest

from pytest_hricdv.session.feature import Feature
from pytest_hricdv.session.option import Flag, OptionReader, Repeatable, Value
from pytest_hricdv.session.options import Options
from pytest_hricdv.session.remote import Remote, RemoteProject, Workers


@dataclass(frozen=True)
class ClusterOptions:
    """The cluster on which the closing loop and a search run tests.

    Args:
        address: as `Address.parse` reads it; empty: none.
        send_code: send the project to the workers, which lack it. send_hidden: patterns of its hidden files to send,
            too.
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
        Flag(
            "send-code",
            "send the project to the workers of --hri-cluster, which otherwise have it at the same path",
            shown=False,
        ),
        Repeatable(
            "send-hidden",
            "PATTERN",
            "with --hri-send-code, send hidden files with this name, as .robot.toml, too",
            "hidden files that --hri-send-code sends, too: a name or a pattern a line",
            shown=False,
        ),
    )

    def read(self, reader: OptionReader) -> ClusterOptions:
        """The cluster that is named."""
        return ClusterOptions(reader.text("cluster"), reader.flag("send_code"), reader.texts("send_hidden"))


FEATURE = ClusterFeature()


class DaskCluster(Remote):
    """Workers of Dask distributed, which is imported when they are needed."""

    def address(self, text: str) -> str:
        """See `Remote`."""
        from pytest_hricdv.extra.cluster.connection import Address

        return str(Address.parse(text))

    def address_of_session(self, options: Options) -> str:
        """See `Remote`."""
        text = FEATURE.settings(options).address
        return self.address(text) if text else ""

    def project_of_session(self, config: pytest.Config, options: Options) -> RemoteProject:
        """See `Remote`."""
        settings, here = FEATURE.settings(options), config.invocation_params.dir
        return self.project(Path(config.rootpath), here, send=settings.send_code, hidden=settings.send_hidden)

    def project(
        self, root: Path, here: Path, *, send: bool, state: Path | None = None, hidden: Sequence[str] = ()
    ) -> RemoteProject:
        """See `Remote`."""
        from pytest_hricdv.extra.cluster.code_archive import worker_project

        return worker_project(root, here, send=send, state=state, hidden=hidden)

    def connect(self, address: str, say: Callable[[str], None]) -> AbstractContextManager[Workers]:
        """See `Remote`."""
        from pytest_hricdv.extra.cluster.cluster import connect
        from pytest_hricdv.extra.cluster.connection import Address

        return connect(Address.parse(address), say)


REMOTE = DaskCluster()
