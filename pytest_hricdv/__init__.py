"""Coverage-driven verification of robot code in human-robot interaction, as a pytest plugin."""
