"""A node whose stop may be taken in the middle of a step, by another thread of its executor."""

import rclpy
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import Bool, Empty


class Robot(Node):
    group = ReentrantCallbackGroup

    def __init__(self):
        super().__init__("robot")
        group = self.group()
        self.stopped = False
        self.moving = self.create_publisher(Bool, "moving", 10)
        self.create_subscription(Empty, "stop", self.stop, 10, callback_group=group)
        self.create_timer(0.1, self.step, callback_group=group)

    def step(self):
        if not self.stopped:
            self.moving.publish(Bool(data=True))

    def stop(self, _):
        self.stopped = True
        self.moving.publish(Bool(data=False))


class Repaired(Robot):
    group = MutuallyExclusiveCallbackGroup


def work(node):
    rclpy.init()
    executor = MultiThreadedExecutor(num_threads=4)
    executor.add_node(node())
    executor.spin()


def work_robot():
    work(Robot)


def work_repaired():
    work(Repaired)
