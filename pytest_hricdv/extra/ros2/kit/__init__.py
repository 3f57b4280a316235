"""Fakes of what surrounds a node under test: a base, a laser, servers of actions, managed nodes, bags.

Each takes the system that `run.ros2` returned, and uses what its `node` has.
"""
