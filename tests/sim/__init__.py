"""Tests of the simulated world: each claim by what the bodies do."""
