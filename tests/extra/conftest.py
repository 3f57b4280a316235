"""The user's project that parts are tested on, as in `tests/plugin`."""

from tests.plugin.conftest import cache_folder, lamps

__all__ = ["cache_folder", "lamps"]
