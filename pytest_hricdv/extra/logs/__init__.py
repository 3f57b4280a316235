"""Logs of the real robot, judged by the testbench's requirements.

log_map     maps topics and fields of a log to messages and signals
logged_run  the parts of a log, their gaps, and their events
judging     verdicts; requirements without data are unknown
log_report  the report of logs
command     `hricdv check`
"""
