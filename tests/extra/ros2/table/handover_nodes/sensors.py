"""Puts the trackers of gaze, grip and hand together: whether the person is ready, while somebody wants to know."""

import rclpy
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import Bool, UInt8

TRACKERS = ("gaze", "pressure", "location")
"""The first one is bit 0 of what is published. All trackers are read at the same time, the last one last."""


class Sensors(Node):
    def __init__(self):
        super().__init__("sensors")
        self.latest = dict.fromkeys(TRACKERS, False)
        self.trackers = []
        events = PublisherEventCallbacks(matched=self.on_matched)
        self.readiness = self.create_publisher(UInt8, "sensors/readiness", 10, event_callbacks=events)

    def on_matched(self, info):
        """Listen to the trackers only while somebody listens here."""
        if info.current_count and not self.trackers:
            for name in TRACKERS:
                callback = lambda message, name=name: self.on_tracker(name, message.data)  # noqa: E731
                self.trackers.append(self.create_subscription(Bool, f"trackers/{name}", callback, 10))
        elif not info.current_count:
            for tracker in self.trackers:
                self.destroy_subscription(tracker)
            self.trackers = []

    def on_tracker(self, name, is_ready):
        self.latest[name] = is_ready
        if name == TRACKERS[-1]:
            self.readiness.publish(UInt8(data=sum(self.latest[each] << bit for bit, each in enumerate(TRACKERS))))


def main():
    rclpy.init()
    try:
        rclpy.spin(Sensors())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()
