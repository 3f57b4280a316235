"""Sessions in this process, as in `tests/plugin`, which loads once what does not take well to being loaded again."""

from tests.plugin.conftest import cache_folder

__all__ = ["cache_folder"]
