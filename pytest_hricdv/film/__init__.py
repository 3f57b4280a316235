"""Films of runs: what a camera is, when it takes pictures, what is drawn on them, and the files they end in.

Nothing here knows what is filmed. Pillow and the encoder are imported only where a film is made.
"""
