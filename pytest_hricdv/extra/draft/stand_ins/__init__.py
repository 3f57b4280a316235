"""Stand-ins for the code's hardware, bus and queues, and the person who acts on it.

A drafted testbench declares them, and a user replaces them one by one by a simulator.
"""
