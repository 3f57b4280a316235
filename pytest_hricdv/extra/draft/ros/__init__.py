"""What is particular to ROS 2: nodes that use `rclpy`, executables, interface files and launch files."""
