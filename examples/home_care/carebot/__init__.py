"""The home-care robot's own code: orders, tasks, driving, gripper, charger.

It runs in one event loop of asyncio, and knows its bus and its ports only: nothing of tests, or of a simulated flat.
"""
