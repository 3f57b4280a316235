"""The skeleton of a project: a testbench that runs, to be replaced part by part."""
