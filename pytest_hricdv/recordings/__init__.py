"""Recordings of real systems, for drafts and checks: files from outside, read within limits.

- `containers` (the messages of MCAP files and SQLite bags, as bytes)
- `bags` (which files a bag has; the fields of its messages)
- `message_order` (messages in the order of time, as the recorder or a simulation had it)
- `recording` (what was recorded, in the order of time, with what is wrong with it)
"""
