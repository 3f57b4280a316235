"""Drafts: a testbench generated from the code under test, its first runs, and recordings of the real system.

From the ground up, each imports only those before it, and `lint-imports` keeps it so:

- `ros_model`, `code_model`: what is known of the code, as plain data;
- `code`, `ros`: static analysis of a package, and of nodes, executables and interface files of ROS 2;
- `analysis`, `node_analysis`: the model of a package, and of a node of ROS 2;
- `observe`, `observed_calls`, `observed_code`, `recorded`: what running code and recordings add to it;
- `draft_analysis`: all of it together;
- `project`: the files of the project;
- `first_runs`, `settlement`, `settling`: how its tests end, and what changes in it then;
- `drift`, `update`, `feature`: the comparison of the code with an existing testbench.
"""
