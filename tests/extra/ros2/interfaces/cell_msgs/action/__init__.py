from types import SimpleNamespace

from cell_msgs import generated

_MODULE = "cell_msgs.action._fetch"
_Id = generated(_MODULE, "UUID", uuid=[0] * 16)
_Goal = generated(_MODULE, "Fetch_Goal", part="")
_Result = generated(_MODULE, "Fetch_Result", found=False)


class _SendGoal:
    Request = generated(_MODULE, "Fetch_SendGoal_Request", goal_id=_Id(), goal=_Goal())
    Response = generated(_MODULE, "Fetch_SendGoal_Response", accepted=False)


class _GetResult:
    Request = generated(_MODULE, "Fetch_GetResult_Request", goal_id=_Id())
    Response = generated(_MODULE, "Fetch_GetResult_Response", status=0, result=_Result())


for _kind, _name in ((_SendGoal, "Fetch_SendGoal"), (_GetResult, "Fetch_GetResult")):
    _kind.__module__, _kind.__name__ = _MODULE, _name


class Fetch:
    Goal = _Goal
    Feedback = generated(_MODULE, "Fetch_Feedback", way=0.0)
    Result = _Result
    Impl = SimpleNamespace(SendGoalService=_SendGoal, GetResultService=_GetResult)
