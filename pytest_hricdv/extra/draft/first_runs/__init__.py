"""Running what was drafted: tests in virtual time, with effects outside refused, and what comes of them."""
