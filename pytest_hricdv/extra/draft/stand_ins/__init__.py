"""Stand-ins: what code gets instead of its hardware, its bus and its queues, and the person who acts on it.

A drafted testbench declares them, and a user replaces them one by one by a simulator.
"""
