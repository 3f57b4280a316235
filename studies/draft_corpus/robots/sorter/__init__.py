"""Bench assistant that sorts screws and hands over tools: worker threads, a dispatcher, a gripper on a serial line."""
