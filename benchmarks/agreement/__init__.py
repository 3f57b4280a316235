"""The original's own tests run here, and what comes of them compared with what came of them then."""
