"""A courier in an office: threads, queues of dicts, no annotations."""
