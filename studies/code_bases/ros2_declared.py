"""What a person who writes testbenches for public packages of ROS 2 by hand declares. Written before drafts were made.

Each name in `MESSAGES` is a topic, service or action as `Ros2` declares it, and which side the node has of it. None of
these nodes has a machine of states, and none compares or says texts that a person would declare.
"""

from __future__ import annotations

OBSTACLE_DETECTION = (
    "subscription /scan sensor_msgs/msg/LaserScan",
    "subscription /cmd_vel_raw geometry_msgs/msg/Twist",
    "publisher /cmd_vel geometry_msgs/msg/Twist",
)

FIBONACCI_SERVER = ("action server /fibonacci example_interfaces/action/Fibonacci",)

DANCE = (
    "publisher /cmd_lightring irobot_create_msgs/msg/LightringLeds",
    "publisher /cmd_vel geometry_msgs/msg/Twist",
    "client /motion_control/set_parameters rcl_interfaces/srv/SetParameters",
)
