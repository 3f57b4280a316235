"""Folders that another user of the machine cannot change."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest

from pytest_hricdv.extra.cluster.private_folder import UnsafeFolderError, private_folder, require_safe

AS_ROOT = pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() != 0, reason="only root can give a folder away")
OTHER = 12345  # a user id that nobody has


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """A folder of this user's."""
    tmp_path.chmod(0o700)
    return tmp_path


def test_it_is_for_this_user_only_and_gone_afterwards(place: Path) -> None:
    before = os.umask(0)
    try:
        with private_folder("code", place) as folder:
            status = folder.stat()
            assert stat.S_IMODE(status.st_mode) == 0o700
            assert status.st_uid == os.getuid()
            (folder / "file").touch()
    finally:
        os.umask(before)
    assert list(place.iterdir()) == []


@pytest.mark.parametrize("mode", [0o777, 0o707, 0o2777, 0o773])
def test_a_folder_in_which_anybody_can_exchange_files_is_refused(place: Path, mode: int) -> None:
    shared = place / "shared"
    shared.mkdir()
    shared.chmod(mode)
    (shared / "own").mkdir(mode=0o700)
    for folder in (shared, shared / "own"):  # whoever may write to the one above renames the one below
        with pytest.raises(UnsafeFolderError, match=r"shared: others may write to it \(mode \d+, not sticky\).*TMPDIR"):
            require_safe(folder)
    with pytest.raises(UnsafeFolderError), private_folder("code", shared):
        pass
    assert [entry.name for entry in shared.iterdir()] == ["own"]


@AS_ROOT
@pytest.mark.parametrize("mode", [0o700, 0o755, 0o1777])
def test_a_folder_of_another_user_is_refused(place: Path, mode: int) -> None:
    (place / "theirs" / "own").mkdir(parents=True)
    os.chown(place / "theirs", OTHER, OTHER)
    (place / "theirs").chmod(mode)
    for folder in (place / "theirs", place / "theirs" / "own"):
        with pytest.raises(UnsafeFolderError, match=rf"theirs: it belongs to user {OTHER}, so that another user can"):
            require_safe(folder)


@AS_ROOT
def test_a_link_is_judged_by_where_it_leads(place: Path) -> None:
    (place / "theirs").mkdir()
    os.chown(place / "theirs", OTHER, OTHER)
    (place / "link").symlink_to(place / "theirs")
    with pytest.raises(UnsafeFolderError, match="theirs: it belongs"):
        require_safe(place / "link")
