"""Fuzzing of everything that reads files and texts from outside: only documented errors, soon, in little memory."""
