"""Gates: what a run has to reach, what is put up with, and what it is held against."""
