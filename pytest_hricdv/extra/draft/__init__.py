"""Drafts: a testbench, made of the code under test, its first runs, and recordings of the real system.

`analysis.analyse` reads a package without importing it, and returns a `code_model.CodeModel`; `node_analysis` and
`launch_analysis` do so for a node and a launch file of ROS 2, and `recorded` adds what a recording shows. `command`
writes the project. `drift` compares such a model with a testbench that exists. From the ground up, each imports only
those before it, and `lint-imports` keeps it so:

- `ros_model`, `code_model`: what is known of the code, as plain data;
- `code`: the source, parsed, and what is read of it; `ros`: the same of nodes, executables, interface and launch files;
- `bags`, `recording`, `observed`: recordings, and what they show;
- `analysis`, `node_analysis`, `launch_analysis`, `recorded`: all of it together;
- `project`: the files of the project; `first_runs`: how its tests end, and what changes in it then;
- `drift`, `update`, `feature`: the comparison with a testbench, and the lines to add.
"""
