"""Fakes of what surrounds a ROS 2 node, for testbenches: bags, a mobile base with a laser, action servers."""

from pytest_hricdv.extra.ros2.kit.bag import BagPlayer
from pytest_hricdv.extra.ros2.kit.base import Laser, PlanarBase, PlanarPose
from pytest_hricdv.extra.ros2.kit.servers import JointTrajectoryFollower, ManagedNode, Navigation

__all__ = ["BagPlayer", "JointTrajectoryFollower", "Laser", "ManagedNode", "Navigation", "PlanarBase", "PlanarPose"]
