"""Actions: goals, their states, cancellations and results, on what stands for the extension."""

from __future__ import annotations

import sys
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from pytest_hricdv.extra.ros2.action_client import ActionClient
from pytest_hricdv.extra.ros2.action_server import ActionGoalHandle, ActionServer
from pytest_hricdv.extra.ros2.actions import GoalEvent, GoalState
from pytest_hricdv.extra.ros2.clocks import Clock, ClockType
from pytest_hricdv.extra.ros2.handles import RCLError
from pytest_hricdv.extra.ros2.qos import ACTION_STATUS, Profile
from pytest_hricdv.extra.ros2.wait_set import WaitSet
from pytest_hricdv.runtime import Kernel
from tests.extra.ros2.system import _Generated, node, run

_PROFILES = (Profile(), Profile(), Profile(), Profile(), ACTION_STATUS)


class _Message(_Generated):
    __slots__ = ("goal", "goal_info", "goal_status", "goals_canceling", "return_code", "status_list")


class _Service:
    Request = Response = _Message


class _Fetch:
    """An action."""

    Impl = SimpleNamespace(
        SendGoalService=_Service,
        CancelGoalService=_Service,
        GetResultService=_Service,
        FeedbackMessage=_Message,
        GoalStatusMessage=_Message,
    )


class _Id(_Generated):
    __slots__ = ("uuid",)


class _Stamp(_Generated):
    __slots__ = ("nanosec", "sec")


class _Info(_Generated):
    __slots__ = ("goal_id", "stamp")


def _info(number: int, sec: int = 0) -> _Info:
    return _Info(goal_id=_Id(uuid=[number] * 16), stamp=_Stamp(sec=sec, nanosec=0))


def _server(name: str = "robot", timeout_s: float = 10.0) -> ActionServer:
    return ActionServer(node(name), Clock(ClockType.STEADY_TIME), _Fetch, "fetch", *_PROFILES, timeout_s)


def _cancelled(server: ActionServer, info: _Info) -> tuple[int | None, list[int]]:
    response = server.process_cancel_request(_Message(goal_info=info), _Message)
    return response.return_code, [each.goal_id.uuid[0] for each in response.goals_canceling]


def test_a_goal_goes_through_its_states() -> None:
    def robot(kernel: Kernel) -> None:
        server = _server()
        handle = ActionGoalHandle(server, _info(1))
        with pytest.raises(RCLError, match="goal ID already exists"):
            ActionGoalHandle(server, _info(1))
        with pytest.raises(RCLError, match="ACCEPTED has no SUCCEED"):
            handle.update_goal_state(GoalEvent.SUCCEED)
        for event, state in (
            (GoalEvent.EXECUTE, GoalState.EXECUTING),
            (GoalEvent.CANCEL_GOAL, GoalState.CANCELING),
            (GoalEvent.CANCELED, GoalState.CANCELED),
        ):
            assert handle.is_active()
            handle.update_goal_state(event)
            assert handle.get_status() == state
        assert not handle.is_active()

    run(robot)


def test_a_cancellation_means_one_goal_those_up_to_a_time_or_all() -> None:
    def robot(kernel: Kernel) -> None:
        server = _server()
        handles = {number: ActionGoalHandle(server, _info(number, sec=number)) for number in (1, 2, 3, 4)}
        handles[2].update_goal_state(GoalEvent.EXECUTE)
        handles[2].update_goal_state(GoalEvent.ABORT)
        assert _cancelled(server, _info(1)) == (0, [1])
        assert _cancelled(server, _info(2)) == (3, [])
        assert _cancelled(server, _info(9)) == (2, [])
        assert _cancelled(server, _info(0))[1] == [1, 3, 4]
        assert _cancelled(server, _info(0, sec=3))[1] == [1, 3]
        assert _cancelled(server, _info(4, sec=1))[1] == [1, 4]

    run(robot)


def test_a_result_is_forgotten_some_time_after_the_goal_is_over() -> None:
    seen: list[Any] = []

    def robot(kernel: Kernel) -> None:
        server = _server(timeout_s=10.0)
        for number in (1, 2):
            handle = ActionGoalHandle(server, _info(number))
            handle.update_goal_state(GoalEvent.EXECUTE)
            kernel.sleep(3.0)
            handle.update_goal_state(GoalEvent.SUCCEED)
            server.notify_goal_done()
        for _ in range(2):
            waiting = WaitSet()
            server.add_to_waitset(waiting)
            waiting.wait(-1)
            assert server.is_ready(waiting) == (False, False, False, True)
            seen.append((kernel.now_s, [each.goal_id.uuid[0] for each in server.expire_goals(5)]))
        assert not server.goal_exists(_info(1))

    assert run(robot)[1] == "idle"
    assert seen == [(13.0, [1]), (16.0, [2])]


def test_a_client_asks_and_hears(monkeypatch: pytest.MonkeyPatch) -> None:
    messages = ModuleType("action_msgs.msg")
    vars(messages)["GoalStatus"] = lambda goal_info, status: _Message(goal_status=status)
    monkeypatch.setitem(sys.modules, "action_msgs", ModuleType("action_msgs"))
    monkeypatch.setitem(sys.modules, "action_msgs.msg", messages)
    seen: list[Any] = []

    def wait(end: ActionClient | ActionServer) -> list[int]:
        waiting = WaitSet()
        end.add_to_waitset(waiting)
        waiting.wait(-1)
        return [index for index, ready in enumerate(end.is_ready(waiting)) if ready]

    def robot(kernel: Kernel) -> None:
        server = _server()
        assert wait(server) == [0]
        header, request = server.take_goal_request(_Message)
        assert header is not None
        assert request is not None
        handle = ActionGoalHandle(server, _info(request.goal))
        server.send_goal_response(header, _Message(goal=request.goal))
        kernel.sleep(2.0)
        handle.update_goal_state(GoalEvent.EXECUTE)
        server.publish_status()
        kernel.sleep(2.0)
        server.publish_feedback(_Message(goal=50))

    def human(kernel: Kernel) -> None:
        client = ActionClient(node("human"), _Fetch, "fetch", *_PROFILES)
        while not client.is_action_server_available():
            kernel.sleep(0.5)
        number = client.send_goal_request(_Message(goal=7))
        assert wait(client) == [2]
        answered, response = client.take_goal_response(_Message)
        assert response is not None
        assert (answered, response.goal) == (number, 7)
        assert wait(client) == [1]
        seen.append((kernel.now_s, client.take_status(_Message).status_list[0].goal_status))
        assert wait(client) == [0]
        seen.append((kernel.now_s, client.take_feedback(_Message).goal))
        assert client.take_feedback(_Message) is None
        assert client.take_result_response(_Message) == (None, None)

    assert run(human, robot)[1] == "idle"
    assert seen == [(2.5, GoalState.EXECUTING), (4.5, 50)]
