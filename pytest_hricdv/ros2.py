"""Stand-ins for what surrounds a node of ROS 2; and `python -m pytest_hricdv.ros2`, how far nodes behave as there."""

import sys

from pytest_hricdv.extra.ros2.kit.arm import JointTrajectoryFollower
from pytest_hricdv.extra.ros2.kit.bag import BagPlayer
from pytest_hricdv.extra.ros2.kit.base import PlanarBase, PlanarPose
from pytest_hricdv.extra.ros2.kit.laser import Laser
from pytest_hricdv.extra.ros2.kit.managed import ManagedNode
from pytest_hricdv.extra.ros2.kit.navigation import Navigation

__all__ = ["BagPlayer", "JointTrajectoryFollower", "Laser", "ManagedNode", "Navigation", "PlanarBase", "PlanarPose"]

if __name__ == "__main__":
    from pytest_hricdv._base.output import work_on_unread
    from pytest_hricdv.extra.ros2.__main__ import main

    work_on_unread()
    sys.exit(main())
