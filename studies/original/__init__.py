"""Data of the original experiment: the paper's figures, and the runs whose commands are recorded."""
