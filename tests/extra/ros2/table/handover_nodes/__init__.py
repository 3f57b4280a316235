"""The handover of table legs as nodes of ROS 2: voice, sensors and robot. They use `rclpy` only."""
