"""What goes on from single runs: failing tests made short, violations searched for, runs repeated to the bit.

Domain-free: a test is a list of actions with parameters, and a run is a function that is handed in.
"""
