"""`python -m pytest_hricdv.ros2`: how far nodes behave as on a middleware of ROS 2; see `pytest_hricdv.extra.ros2`."""

import sys

from pytest_hricdv.extra.ros2.__main__ import main

if __name__ == "__main__":
    sys.exit(main())
