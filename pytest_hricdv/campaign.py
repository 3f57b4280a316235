"""`hricdv campaign`: runs each test with many seeds; see `pytest_hricdv.extra.campaign`."""

import sys

from pytest_hricdv._base.command_line import work_on_unread
from pytest_hricdv.extra.campaign.__main__ import main

if __name__ == "__main__":
    work_on_unread()
    sys.exit(main())
