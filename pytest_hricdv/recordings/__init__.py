"""Recordings of real systems, for drafts and checks: files from outside, read within limits.

- `containers` (the messages of MCAP files and SQLite bags, as bytes)
- `bags` (the files of a bag; the fields of its messages)
- `message_order` (messages in the order of time, of the recorder or of a simulation)
- `recording` (messages in the order of time, and problems of the recording)
"""
