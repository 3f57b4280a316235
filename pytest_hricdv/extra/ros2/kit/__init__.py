"""Stand-ins for what surrounds a node under test: bases, lasers, navigation, arms, managed nodes.

Each takes the system that `run.ros2` returned, and uses what its `node` has.
"""
