"""Small systems of `rclpy` that run on a real middleware and in virtual time, and have to log the same in both."""
