"""How often diagnosis counts causes right, for docs/diagnosis.md: a planted fault is one cause, two at once are two."""
