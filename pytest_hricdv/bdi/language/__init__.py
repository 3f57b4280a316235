"""The AgentSpeak language: terms, formulas, syntax trees, and how they are read from text. Knows nothing of agents."""
