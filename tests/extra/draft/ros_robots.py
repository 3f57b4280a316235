"""Small nodes of ROS 2, as people write them: source text by name."""

from __future__ import annotations

ARM = """
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import Bool, Empty


class ArmNode(Node):
    def __init__(self):
        super().__init__("arm")
        self.period_s = self.declare_parameter("period_s", 0.1).value
        self.is_near = False
        self.left_s = 0.0
        self.moving = self.create_publisher(Bool, "arm/moving", 10)
        self.done = self.create_publisher(Empty, "~/done", 10)
        self.create_subscription(Empty, "request", self.on_request, 10)
        self.create_subscription(msg_type=Bool, topic="/somebody_near", callback=self.on_person, qos_profile=10)
        self.create_timer(self.period_s, self.step)

    def on_request(self, _):
        self.left_s = 2.0

    def on_person(self, message):
        self.is_near = message.data

    def step(self):
        if self.left_s <= 0.0:
            return
        moves = not self.is_near
        self.left_s -= self.period_s * moves
        self.moving.publish(Bool(data=moves and self.left_s > 0.0))
        if self.left_s <= 0.0:
            self.done.publish(Empty())


def main():
    rclpy.init()
    try:
        rclpy.spin(ArmNode())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
"""
"""A class of a node, with topics by name and by keyword, a private name, a parameter and a timer."""

DOOR = """
import rclpy
import std_srvs.srv as services
from std_msgs.msg import String

STATES = "door/state"


def main(args=None):
    rclpy.init(args=args)
    node = rclpy.create_node("door", namespace="/home")
    node.declare_parameters("limits", [("open_s", 5.0), ("name", "front")])
    node.declare_parameter("command_topic", "commands")
    said = node.create_publisher(String, STATES, 10)

    def on_command(message):
        if message.data == "open":
            said.publish(String(data="opened"))
        elif message.data == "close":
            said.publish(String(data="closed"))

    def on_lock(request, response):
        response.success = bool(request.data)
        return response

    topic = node.get_parameter("command_topic").value
    node.create_subscription(String, topic, on_command, 10)
    node.create_service(services.SetBool, "lock", on_lock)
    rclpy.spin(node)
"""
"""A node that a function makes, in a namespace, with a topic whose name is a parameter, and a service."""

TRANSPORT = """
import rclpy
from nav2_msgs.action import NavigateToPose
from rclpy.action import ActionClient, ActionServer
from rclpy.node import Node
from std_srvs.srv import Trigger
from transport_msgs.action import Fetch


class Base(Node):
    def __init__(self, name):
        super().__init__(name)
        self.gripper = self.create_client(Trigger, "grip")


class Transport(Base):
    def __init__(self, robot):
        super().__init__("transport")
        self.server = ActionServer(self, Fetch, "fetch", execute_callback=self.fetch)
        self.drive = ActionClient(self, NavigateToPose, "navigate_to_pose")
        self.log = self.create_publisher(robot.log_type, f"/{robot.name}/log", 10)

    def fetch(self, goal_handle):
        goal_handle.succeed()
        return Fetch.Result()


def main():
    rclpy.init()
    rclpy.spin(Transport(None))
"""
"""A derived class, actions served and used, a service used, and a topic that the source does not name."""
