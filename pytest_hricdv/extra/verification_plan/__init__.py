"""The verification plan: goals, and how far a session is from them."""
