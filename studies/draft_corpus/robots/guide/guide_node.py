"""A museum guide as a node of ROS 2."""

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import Range
from std_msgs.msg import Bool, String
from std_srvs.srv import SetBool

TEXTS = {"vase": "This vase is old.", "mask": "This mask was worn once a year.", "coin": "Found in 1911."}


class Guide(Node):
    def __init__(self):
        super().__init__("guide")
        self.state = "waiting"
        self.exhibit = None
        self.timer_count = 0
        self.muted = False
        self.speed = self.declare_parameter("speed", 0.4).value
        self.cmd = self.create_publisher(Twist, "cmd_vel", 10)
        self.speech = self.create_publisher(String, "speech", 10)
        self.state_pub = self.create_publisher(String, "guide_state", 10)
        self.create_subscription(String, "wish", self.on_wish, 10)
        self.create_subscription(Bool, "touched", self.on_touch, 10)
        self.create_subscription(Range, "front", self.on_range, 10)
        self.create_service(SetBool, "mute", self.on_mute)
        self.create_timer(0.5, self.tick)

    def change(self, state):
        self.state = state
        self.timer_count = 0
        self.state_pub.publish(String(data=state))

    def on_wish(self, msg):
        if msg.data == "stop":
            self.change("waiting")
        elif msg.data in TEXTS and self.state == "waiting":
            self.exhibit = msg.data
            self.change("walking")
        else:
            self.say("I do not know this one.")

    def on_touch(self, msg):
        if msg.data and self.state == "walking":
            self.change("paused")
        elif not msg.data and self.state == "paused":
            self.change("walking")

    def on_range(self, msg):
        if msg.range < 0.5 and self.state == "walking":
            self.say("Excuse me, please.")
            self.change("paused")

    def on_mute(self, request, response):
        self.muted = request.data
        response.success = True
        return response

    def say(self, text):
        if not self.muted:
            self.speech.publish(String(data=text))

    def tick(self):
        self.timer_count += 1
        twist = Twist()
        if self.state == "walking":
            twist.linear.x = self.speed
            if self.timer_count > 8:
                self.change("explaining")
                self.say(TEXTS[self.exhibit])
        elif self.state == "explaining" and self.timer_count > 6:
            self.change("waiting")
        elif self.state == "paused" and self.timer_count > 20:
            self.change("waiting")
        self.cmd.publish(twist)


def main():
    rclpy.init()
    rclpy.spin(Guide())


if __name__ == "__main__":
    main()
