"""Mutation testing: mutants of the code under test, to find out how many of them the tests kill.

source             a file of the code under test as a syntax tree: which places may be changed
names              what its names stand for: constants of one kind, opposite commands, times and speeds
robot_operators    changes that robot code suffers from: messages, waits, times, states, resets, commands
operators          all operators: these, and those of mutmut
mutants            every mutant of the code, once
"""
