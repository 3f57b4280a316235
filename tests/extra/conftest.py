"""The user's project that parts are tested on, as in `tests/plugin`."""

from tests.plugin.conftest import after, cache_folder, finished, finished_sessions, lamps

__all__ = ["after", "cache_folder", "finished", "finished_sessions", "lamps"]
