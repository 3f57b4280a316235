"""The handover machine: fetches a leg when it is asked, offers it, and lets go when the person is ready."""

import json
import queue
import threading
import time

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import Bool, Empty, String, UInt8
from std_srvs.srv import SetBool, Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from handover_nodes.ways import HOME, TO_HANDOVER, TO_PICKUP, TO_RESUPPLY

ALL_READY = 0b111
ARM_PATIENCE_S = 120.0


class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.turns = self.declare_parameter("turns", 4).value
        self.sensing_timeout_s = self.declare_parameter("sensing_timeout_s", 30.0).value
        self.on_time_s = self.declare_parameter("on_time_s", 300.0).value
        self.requests, self.readies, self.arrivals = queue.Queue(), queue.Queue(), queue.Queue()
        self.outcomes = []
        self.state = self.create_publisher(String, "robot/state", 10)
        self.said = self.create_publisher(String, "voice/say", 10)
        self.trajectory = self.create_publisher(JointTrajectory, "arm/trajectory", 10)
        self.create_subscription(Empty, "voice/leg_wanted", self.requests.put, 10)
        self.create_subscription(Empty, "voice/human_ready", self.readies.put, 10)
        self.create_subscription(Bool, "arm/arrived", lambda message: self.arrivals.put(message.data), 10)
        self.hand = self.create_client(SetBool, "hand/close")
        self.holding = self.create_client(Trigger, "hand/holds")

    # What the robot does; each call blocks until it is done.

    def move(self, way):
        points = [JointTrajectoryPoint(positions=list(pose)) for pose in way]
        self.trajectory.publish(JointTrajectory(points=points))
        return self.arrivals.get(timeout=ARM_PATIENCE_S)

    def close(self, on):
        return self.hand.call(SetBool.Request(data=on)).success

    def holds(self):
        return self.holding.call(Trigger.Request()).success

    # The states.

    def work(self):
        began_s = self.now_s()
        self.enter("Reset")
        if self.holds():
            self.close(False)
        if not self.move([HOME]):
            return
        forget(self.requests)
        while len(self.outcomes) < self.turns:
            self.await_request()
            outcome = self.hand_over()
            self.outcomes.append(outcome)
            self.said.publish(String(data=f"turn {len(self.outcomes)} {outcome}"))
            forget(self.requests)
        duration_s, released = self.now_s() - began_s, self.outcomes.count("released")
        on_time = released == self.turns and duration_s <= self.on_time_s
        report = {"released": released, "duration_s": duration_s, "on_time": on_time}
        # Spoken, too: on a topic of its own it could overtake the end of the last turn, which goes by the voice.
        self.said.publish(String(data=f"table {json.dumps(report)}"))

    def await_request(self):
        while True:
            self.enter("Receive1")
            if heard(self.requests, polls=60, period_s=0.05):
                return
            self.enter("Timeout1")

    def hand_over(self):
        """One turn, from the request on; how it ended."""
        self.enter("Move_hand")
        if not self.fetch():
            return self.discard("discarded")
        self.enter("Send1")
        forget(self.readies)
        self.said.publish(String(data=f"leg {len(self.outcomes) + 1} is ready"))
        self.enter("Receive2")
        if not heard(self.readies, polls=60, period_s=0.25):
            self.enter("Timeout2")
            return self.discard("no-human-ready")
        self.enter("Wait0")
        time.sleep(2.0)
        self.enter("Sensing")
        readiness = self.sense()
        if readiness is None:
            self.enter("Timeout3")
            return self.discard("sensing-timeout")
        self.enter("Decide")
        if readiness != ALL_READY or not self.holds():
            return self.discard("discarded")
        return self.release()

    def fetch(self):
        if not self.move(TO_PICKUP):
            return False
        for _ in range(2):
            if self.close(True):
                return self.move(TO_HANDOVER) and self.holds()
            self.close(False)
        return False

    def sense(self):
        readings = queue.Queue()
        subscription = self.create_subscription(UInt8, "sensors/readiness", readings.put, 10)
        try:
            return readings.get(timeout=self.sensing_timeout_s).data
        except queue.Empty:
            return None
        finally:
            self.destroy_subscription(subscription)

    def release(self):
        self.enter("Release")
        for attempt in range(5):
            if attempt:
                time.sleep(3.0)
            if self.close(False):
                self.move([HOME])
                return "released"
        self.close(True)
        return self.discard("discarded")

    def discard(self, outcome):
        self.enter("Discard")
        if self.holds():
            self.move(TO_RESUPPLY)
        self.close(False)
        self.move([HOME])
        return outcome

    def enter(self, state):
        self.state.publish(String(data=state))

    def now_s(self):
        return self.get_clock().now().nanoseconds / 1e9


def heard(words, polls, period_s):
    """Whether something is said within a time; looked for now and then."""
    for _ in range(polls):
        if not words.empty():
            words.get()
            return True
        time.sleep(period_s)
    return False


def forget(words):
    while not words.empty():
        words.get()


def main():
    rclpy.init()
    try:
        robot = Robot()
        spinning = threading.Thread(target=rclpy.spin, args=(robot,), daemon=True)
        spinning.start()
        robot.work()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()
