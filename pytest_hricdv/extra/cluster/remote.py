"""Workers of Dask distributed, for everything that runs tests."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from pathlib import Path

import pytest

from pytest_hricdv.extra.cluster.address import Address
from pytest_hricdv.extra.cluster.feature import FEATURE
from pytest_hricdv.session.options import Options
from pytest_hricdv.session.remote import Remote, RemoteProject, Workers


class DaskCluster(Remote):
    """Workers of Dask distributed, which is imported when they are needed."""

    def address(self, text: str) -> str:
        """See `Remote`."""
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
        from pytest_hricdv.extra.cluster.worker_project import worker_project

        return worker_project(root, here, send=send, state=state, hidden=hidden)

    def connect(self, address: str, say: Callable[[str], None]) -> AbstractContextManager[Workers]:
        """See `Remote`."""
        from pytest_hricdv.extra.cluster.cluster import connected

        return connected(Address.parse(address), say)


REMOTE = DaskCluster()
