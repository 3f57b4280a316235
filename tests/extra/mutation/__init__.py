"""Tests of the seeded faults."""
