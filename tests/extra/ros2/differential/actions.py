"""Actions: results, feedback, cancellations, refusals, several goals, results that are kept."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

import rclpy
from action_msgs.srv import CancelGoal
from rclpy.action import ActionClient, ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from test_msgs.action import Fibonacci
from unique_identifier_msgs.msg import UUID

from tests.extra.ros2.differential.common import (
    PATIENCE_S,
    Log,
    Main,
    System,
    alone,
    answered,
    elapse,
    serving,
    together,
    until,
)

_STEP_S = 0.05


def _count(goal: Any) -> Any:
    """Execute a goal: so many steps, each with feedback, until it is cancelled."""
    sequence = [0, 1]
    for _ in range(goal.request.order):
        if goal.is_cancel_requested:
            goal.canceled()
            return Fibonacci.Result(sequence=sequence[:2])
        sequence.append(sequence[-1] + sequence[-2])
        goal.publish_feedback(Fibonacci.Feedback(sequence=sequence))
        time.sleep(_STEP_S)
    goal.succeed()
    return Fibonacci.Result(sequence=sequence)


def _server(node: Node, execute: Callable[[Any], Any] = _count, **options: Any) -> ActionServer:
    return ActionServer(node, Fibonacci, "fibonacci", execute_callback=execute, **options)


def fibonacci(log: Log) -> Node:
    node = Node("fibonacci")

    def accept(request: Any) -> Any:
        log("goal", request.order)
        return GoalResponse.ACCEPT if request.order >= 0 else GoalResponse.REJECT

    def cancel(goal: Any) -> Any:
        log("cancel", [goal.request.order, goal.is_active])
        return CancelResponse.ACCEPT

    node.server = _server(node, goal_callback=accept, cancel_callback=cancel, callback_group=ReentrantCallbackGroup())
    return node


def calling(order: int, *, cancels: bool = False) -> Main:
    """Calls the action."""

    def main(log: Log) -> None:
        rclpy.init()
        node, heard = Node("caller"), []
        client = ActionClient(node, Fibonacci, "fibonacci")
        log("server", client.wait_for_server(timeout_sec=PATIENCE_S))
        sent = client.send_goal_async(
            Fibonacci.Goal(order=order), feedback_callback=lambda each: heard.append(list(each.feedback.sequence))
        )
        goal = answered(node, sent)
        log("accepted", goal.accepted)
        if not goal.accepted:
            return
        if cancels:
            until(node, lambda: len(heard) > 0)
            log("cancelling", len(answered(node, goal.cancel_goal_async()).goals_canceling))
        result = answered(node, goal.get_result_async())
        log("result", [result.status, list(result.result.sequence)])
        until(node, lambda: goal.status == result.status)
        log("status", goal.status)
        if not cancels:
            log("feedback", heard)
        else:
            late = answered(node, goal.cancel_goal_async())
            log("cancelled again", [late.return_code, len(late.goals_canceling)])

    return main


class _Both:
    """A server and a client in one process, which a spinning thread serves."""

    def __init__(self, execute: Callable[[Any], Any] = _count, *, threads: int = 4, **options: Any) -> None:
        rclpy.init()
        self.node, self.caller = Node("server"), Node("caller")
        group = ReentrantCallbackGroup()
        self.server = _server(self.node, execute, callback_group=group, **options)
        self.client = ActionClient(self.caller, Fibonacci, "fibonacci", callback_group=group)
        self.client.wait_for_server(timeout_sec=PATIENCE_S)
        self.spun = MultiThreadedExecutor(num_threads=threads) if threads > 1 else together()
        for node in (self.node, self.caller):
            self.spun.add_node(node)

    def sent(self, order: int, **options: Any) -> Any:
        """The handle of a goal that is answered."""
        return answered(self.spun, self.client.send_goal_async(Fibonacci.Goal(order=order), **options))

    def result(self, goal: Any) -> list[Any]:
        """Status and sequence."""
        response = answered(self.spun, goal.get_result_async())
        return [response.status, list(response.result.sequence)]

    def close(self) -> None:
        self.spun.shutdown()


def aborting(log: Log) -> None:
    """Goals that fail: by the server's decision, by an exception, and by not saying how they end."""

    def execute(goal: Any) -> Any:
        if goal.request.order == 1:
            goal.abort()
        elif goal.request.order == 2:
            raise ValueError("in execute")
        return Fibonacci.Result(sequence=[goal.request.order])

    both = _Both(execute)
    for order in (1, 2, 3):
        log("result", both.result(both.sent(order)))
    both.close()


def refusing(log: Log) -> None:
    """A server that lets nothing be cancelled."""
    both = _Both(cancel_callback=lambda goal: CancelResponse.REJECT)
    goal = both.sent(3)
    response = answered(both.spun, goal.cancel_goal_async())
    log("refused", [response.return_code, len(response.goals_canceling)])
    log("result", both.result(goal))
    late = answered(both.spun, goal.cancel_goal_async())
    log("over", [late.return_code, len(late.goals_canceling)])
    both.close()


def cancelling_all(log: Log) -> None:
    """One request that cancels all goals, as tools send it, and one for a goal that nobody knows."""
    both = _Both(cancel_callback=lambda goal: CancelResponse.ACCEPT)
    client = both.caller.create_client(CancelGoal, "fibonacci/_action/cancel_goal")
    goals = [both.sent(1000), both.sent(1000)]
    unknown = CancelGoal.Request()
    unknown.goal_info.goal_id.uuid = [7] * 16
    response = answered(both.spun, client.call_async(unknown))
    log("unknown", [response.return_code, len(response.goals_canceling)])
    response = answered(both.spun, client.call_async(CancelGoal.Request()))
    log("all", [response.return_code, len(response.goals_canceling)])
    for goal in goals:
        log("result", both.result(goal))
    both.close()


def deferring(log: Log) -> None:
    """Goals that are executed later, one after the other."""
    waiting: list[Any] = []
    order: list[int] = []

    def execute(goal: Any) -> Any:
        order.append(goal.request.order)
        goal.succeed()
        return Fibonacci.Result(sequence=[goal.request.order])

    both = _Both(execute, handle_accepted_callback=waiting.append)
    goals = [both.sent(number) for number in (1, 2, 3)]
    until(both.spun, lambda: len(waiting) == 3)
    log("accepted", [[goal.request.order, goal.is_active, goal.status] for goal in waiting])
    for handle in reversed(waiting):
        handle.execute()
        until(both.spun, lambda handle=handle: handle.request.order in order)
    log("executed", order)
    log("results", [both.result(goal) for goal in goals])
    both.close()


def identified(log: Log) -> None:
    """Identifiers that the client chooses, the same one twice, and results that are asked for twice and forgotten."""
    both = _Both(result_timeout=1)
    own = UUID(uuid=list(range(16)))
    goal = both.sent(0, goal_uuid=own)
    log("same identifier", list(goal.goal_id.uuid) == list(own.uuid))
    log("result", both.result(goal))
    log("again", both.result(goal))
    log("twice", both.sent(0, goal_uuid=own).accepted)
    elapse(both.spun, 2.0)
    log("forgotten", both.result(goal))
    both.close()


def awaiting(log: Log) -> None:
    """Coroutines: the server's callback awaits a timer, the client the goal and its result; one thread does all."""
    over: list[int] = []

    async def execute(goal: Any) -> Any:
        future: Any = rclpy.task.Future()
        timer = both.node.create_timer(_STEP_S, lambda: future.done() or future.set_result(goal.request.order))
        order = await future
        timer.cancel()
        goal.succeed()
        return Fibonacci.Result(sequence=[order])

    async def call() -> None:
        goal = await both.client.send_goal_async(Fibonacci.Goal(order=5))
        response = await goal.get_result_async()
        log("result", [response.status, list(response.result.sequence)])
        over.append(1)

    both = _Both(execute, threads=1)
    both.spun.create_task(call)
    until(both.spun, lambda: bool(over))
    log("over", over)
    both.close()


def blocking(log: Log) -> None:
    """`send_goal` waits for the result, in a thread of its own."""
    both = _Both()
    results: list[Any] = []
    thread = threading.Thread(target=lambda: results.append(both.client.send_goal(Fibonacci.Goal(order=1))))
    thread.start()
    until(both.spun, lambda: bool(results))
    thread.join()
    log("result", [results[0].status, list(results[0].result.sequence)])
    both.close()


SYSTEMS = {
    "action": System({"caller": calling(5)}, {"server": serving(fibonacci, threads=4)}),
    "cancelled action": System({"caller": calling(100, cancels=True)}, {"server": serving(fibonacci, threads=4)}),
    "rejected action": System({"caller": calling(-1)}, {"server": serving(fibonacci, threads=4)}),
    "aborted goals": alone(aborting),
    "refused cancellation": alone(refusing),
    "all goals cancelled": alone(cancelling_all),
    "deferred goals": alone(deferring),
    "identifiers and kept results": alone(identified),
    "actions as coroutines": alone(awaiting),
    "blocking goal": alone(blocking),
}
