"""Logs of the real robot, judged by the testbench's requirements.

log_map     which topic and field of a log is which message and signal
judging     verdicts on a log; what its gaps leave unknown
command     `hricdv check`
"""
