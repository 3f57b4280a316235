"""The standard internal actions, and the functions of expressions."""
