"""A small testbench with three people: a robot brings medicine through a door, between a nurse, a porter and a child.

- `robot` (the code under test: coroutines, with a fault that takes the nurse and the porter in two of six orders)
- `bench` (the world, the people, and the testbench)
- `models/` (what they do)
"""
