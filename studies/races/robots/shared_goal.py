"""A node whose orders and whose control are in two callback groups, which share a goal."""

import threading

import rclpy
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import Bool, Empty


class Goal:
    def __init__(self):
        self.steps_left = 0

    def is_active(self):
        return self.steps_left > 0

    def begin(self):
        self.steps_left = 1000

    def cancel(self):
        self.steps_left = 0

    def advance(self):
        self.steps_left -= 1


class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        orders, control = MutuallyExclusiveCallbackGroup(), MutuallyExclusiveCallbackGroup()
        self.lock = threading.Lock()
        self.goal = Goal()
        self.moving = self.create_publisher(Bool, "moving", 10)
        self.create_subscription(Empty, "go", self.on_go, 10, callback_group=orders)
        self.create_subscription(Empty, "stop", self.on_stop, 10, callback_group=orders)
        self.create_timer(0.1, self.on_timer, callback_group=control)

    def step(self):
        if self.goal.is_active():
            self.goal.advance()
            self.moving.publish(Bool(data=True))

    def halt(self):
        self.goal.cancel()
        self.moving.publish(Bool(data=False))

    def on_go(self, _):
        self.goal.begin()

    def on_stop(self, _):
        self.halt()

    def on_timer(self):
        self.step()


class Repaired(Robot):
    def step(self):
        with self.lock:
            super().step()

    def halt(self):
        with self.lock:
            super().halt()

    def on_go(self, _):
        with self.lock:
            self.goal.begin()


def work(node):
    rclpy.init()
    executor = MultiThreadedExecutor(num_threads=4)
    executor.add_node(node())
    executor.spin()


def work_robot():
    work(Robot)


def work_repaired():
    work(Repaired)
