"""A draft of a testbench, made of the code that is to be tested: what it says, hears, its states, how it waits.

`analysis.analyse` reads a package without importing it, and returns `found.findings.Findings`, which are plain data;
`node_analysis` and `launch_analysis` do so for a node and a launch file of ROS 2, and `recorded` adds what a recording
shows. `command` ties all together. Each folder below imports only those before it, and `lint-imports` keeps it so:

- `found`: what is found, as plain data;
- `reading`: source, parsed, and what its names and expressions come to;
- `messages`, `ros`, `states`, `surroundings`: what is looked for in it;
- `writing`: the files of the project, and `writing.templates`, their longest pieces;
- `first_runs`: how the project's tests end, and what is changed in it then.
"""
