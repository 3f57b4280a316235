"""The original's own tests run here, and their results compared with the original's."""
