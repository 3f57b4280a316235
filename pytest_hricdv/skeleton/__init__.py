"""The skeleton of a project: a testbench that runs out of the box, whose parts a user replaces one by one."""
