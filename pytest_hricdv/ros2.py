"""Fakes for the environment of a ROS 2 node."""

from pytest_hricdv.extra.ros2.kit.bag import BagPlayer
from pytest_hricdv.extra.ros2.kit.base import Laser, PlanarBase, PlanarPose
from pytest_hricdv.extra.ros2.kit.servers import JointTrajectoryFollower, ManagedNode, Navigation

__all__ = ["BagPlayer", "JointTrajectoryFollower", "Laser", "ManagedNode", "Navigation", "PlanarBase", "PlanarPose"]
