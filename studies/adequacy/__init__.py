"""How many seeded faults each suite notices."""
