"""Recordings of a real system: what was said, when, and with which values.

decoding           the fields of recorded messages
recording          reads bags of ROS 2 and MCAP files, and says what is wrong with them
observed           what recordings show: ranges of numbers, texts, times between messages and to reactions
"""
