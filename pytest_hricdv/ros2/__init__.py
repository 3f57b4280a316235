"""ROS 2 code in virtual time: what stands for the extension `_rclpy_pybind11`, on which the Python of `rclpy` rests."""
