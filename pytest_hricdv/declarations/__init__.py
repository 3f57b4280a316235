"""Declarations of a testbench for optional features: plain data, without the code that acts on them.

- `bystander` (an actor that no plan describes: what it can do)
- `model_oracle` (an agent of the model that each run is compared with; for `extra.oracle`)
- `film` (camera, key moments and shapes of a world; for `extra.film` and `extra.traces`)
- `ros2` (a ROS 2 system: what requirements name of its graph, and its nodes; for `extra.ros2`)
- `ros2_system` (what `extra.ros2` makes of it in a run, as protocols)
"""
