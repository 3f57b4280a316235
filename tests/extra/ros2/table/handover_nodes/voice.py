"""Recognizes what the person says, and speaks for the robot."""

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import Empty, String

PHRASES = {"give me a leg": "voice/leg_wanted", "i am ready": "voice/human_ready"}


class Voice(Node):
    def __init__(self):
        super().__init__("voice")
        self.heard = {phrase: self.create_publisher(Empty, topic, 10) for phrase, topic in PHRASES.items()}
        self.speaker = self.create_publisher(String, "speaker", 10)
        self.create_subscription(String, "microphone", self.on_speech, 10)
        self.create_subscription(String, "voice/say", self.speaker.publish, 10)

    def on_speech(self, message):
        publisher = self.heard.get(message.data.lower())
        if publisher is None:
            self.get_logger().warning(f"not understood: {message.data}")
        else:
            publisher.publish(Empty())


def main():
    rclpy.init()
    try:
        rclpy.spin(Voice())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()
