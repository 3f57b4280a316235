"""Agents: their mental state, their reasoning cycle, and how they execute plans."""
