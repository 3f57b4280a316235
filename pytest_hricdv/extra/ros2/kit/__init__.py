"""Fakes for the environment of a node under test: a base, a laser, action servers, managed nodes, bags.

Each takes the system that `run.ros2` returned, and uses what its `node` has.
"""
