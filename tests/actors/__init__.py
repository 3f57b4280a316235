"""Several actors, through all of it: a corridor robot between a nurse and a child."""
