"""The pytest integration: collection, running, reporting, and what follows the last test."""
