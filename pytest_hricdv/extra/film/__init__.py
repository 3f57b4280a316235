"""Films of runs: cameras, the schedule of pictures, captions, and film files.

Independent of what is filmed. Pillow and the encoder are imported only when a film is made.
"""
