"""ROS 2 nodes in virtual time: a replacement of `_rclpy_pybind11`, the extension module below the Python of `rclpy`."""
