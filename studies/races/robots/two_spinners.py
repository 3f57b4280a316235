"""Two threads spin one executor, which keeps one generator and one list for both.

The kind of rclpy#1393.
"""

import threading
from contextlib import nullcontext

import rclpy
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import Bool, Empty


class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        group = ReentrantCallbackGroup()
        self.moving = self.create_publisher(Bool, "moving", 10)
        for topic in ("go", "go"):
            self.create_subscription(Empty, topic, self.step, 10, callback_group=group)

    def step(self, _):
        self.moving.publish(Bool(data=True))


def spin(executor, timeout_s, lock):
    while True:
        with lock:
            executor.spin_once(timeout_s)


def work(lock):
    rclpy.init()
    executor = MultiThreadedExecutor(num_threads=4)
    executor.add_node(Robot())
    threading.Thread(target=spin, args=(executor, 0.3, lock), daemon=True).start()
    spin(executor, 0.4, lock)


def work_robot():
    work(nullcontext())


def work_repaired():
    work(threading.Lock())
