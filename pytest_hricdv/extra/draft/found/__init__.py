"""What is found in code, as plain data: messages, states, ports, waits, nodes, each with its place."""
