"""The verification plan: goals, and the progress of a session towards them."""
