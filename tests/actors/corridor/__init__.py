"""A small testbench with two people: a delivery robot in the corridor of a ward, a nurse and a child.

- `cart` (the code under test, with a fault that takes two people)
- `bench` (the world, the people, and the testbench)
- `models/` (what the nurse and the child do)
"""
