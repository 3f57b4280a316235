"""Interface files of packages that are not installed are enough to use their messages."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from pytest_hricdv.declarations.ros2 import Ros2, Ros2Error
from pytest_hricdv.extra.ros2.bridge import vocabulary
from pytest_hricdv.extra.ros2.messages import copy_message, deserialize, import_type, serialize, type_name

MESSAGE = r"""
# Everything that a field can be: "quoted", it's said.
bool is_on true
byte flags
char letter
float32 ratio 0.5  # half
float64[3] position
float64[] ranges [1.0, 2.5]
uint8[<=4] data
int16 below -3
string name "a, b"
string<=5 short hello
wstring wide
string[2] pair
cell_io/Point[] points
Point origin
geometry/Pose pose

uint8 IDLE=0
int32 LOWEST = -5
string GREETING="it's here"
float64 PI=3.14
"""


@pytest.fixture
def made(interfaces: Any) -> Any:
    return interfaces(
        {
            "cell_io/msg/Everything.msg": MESSAGE,
            "cell_io/msg/Point.msg": "float64 x\nfloat64 y 1",
            "geometry/msg/Pose.msg": "cell_io/Point at\n",
            "cell_io/srv/Grasp.srv": "float64 force\n---\nbool held\n",
            "cell_io/srv/Ask.srv": "---\n",
            "cell_io/action/Fetch.action": "# goal\nstring part\n---\nbool found\n---\nfloat32 way\n",
            "cell_io/msg/Wrong.msg": "float64 x\nfloat64\n",
            "cell_io/msg/WrongDefault.msg": "uint8 A=1\nint32 x seven\n",
            "cell_io/msg/Lacking.msg": "absent_msgs/Thing thing\n",
            "cell_io/srv/Single.srv": "float64 x\n",
        }
    )


def test_a_message_is_copied_compared_and_sent_as_bytes(made: None) -> None:
    kind = import_type("cell_io/msg/Everything", "msg")
    message = kind(
        points=[import_type("cell_io/msg/Point", "msg")(x=4.0)], data=[1, 2], wide="é", position=[1.0, 2.0, 3.0]
    )
    copied = copy_message(message)
    assert copied == message
    assert copied.points is not message.points
    copied.points[0].x = 5.0
    assert copied != message
    assert deserialize(serialize(message, kind), kind) == message
    assert "points=[cell_io.msg.Point(x=4.0, y=1.0)]" in repr(message)


@pytest.mark.parametrize(
    ("field", "value", "problem"),
    [
        ("is_on", 1, "The 'is_on' field must be of type 'bool'"),
        ("ratio", 1, "The 'ratio' field must be of type 'float'"),
        ("ratio", 1e39, "The 'ratio' field must be a float in"),
        ("below", 40000, r"The 'below' field must be an integer in \[-32768, 32767\]"),
        ("data", [1] * 5, "The 'data' field must be a set or sequence with at most 4 elements"),
        ("data", [300], r"The 'data' field must be an integer in \[0, 255\]"),
        ("position", [1.0], "The 'position' field must be a set or sequence with 3 elements"),
        ("short", "longer", "The 'short' field must be of at most 5 characters"),
        ("origin", 3, "The 'origin' field must be a sub message of type 'Point'"),
        ("points", [3], "The 'points' field must be a sub message of type 'Point'"),
        ("nmae", "x", "Invalid arguments passed to constructor: nmae; nearest: name"),
    ],
)
def test_a_wrong_value_fails_at_its_line(made: None, field: str, value: Any, problem: str) -> None:
    with pytest.raises(AssertionError, match=problem):
        import_type("cell_io/msg/Everything", "msg")(**{field: value})


def test_services_and_actions_have_their_parts(made: None) -> None:
    from cell_io.action import Fetch  # type: ignore[import-not-found, unused-ignore]
    from cell_io.srv import Ask, Grasp  # type: ignore[import-not-found, unused-ignore]

    assert (Grasp.Request(force=2.0).force, Grasp.Response().held) == (2.0, False)
    assert type_name(Grasp.Request) == "cell_io/srv/Grasp_Request"
    assert (Grasp.Event().request, Ask.Request().get_fields_and_field_types()) == ([], {})
    assert Fetch.Impl.SendGoalService.Request().goal.part == ""
    assert type_name(Fetch.Impl.FeedbackMessage) == "cell_io/action/Fetch_FeedbackMessage"
    assert len(Fetch.Impl.GetResultService.Request().goal_id.uuid) == 16
    assert type_name(Fetch.Impl.CancelGoalService) == "action_msgs/srv/CancelGoal"
    names = vocabulary(Ros2(actions={"/fetch": "cell_io/action/Fetch"}))
    assert names["fetch_result"] == {"status": float, "found": bool}


@pytest.mark.parametrize(
    ("name", "folder", "problem"),
    [
        ("Wrong", "msg", "Wrong.msg:2: 'float64': InvalidFieldDefinition"),
        ("WrongDefault", "msg", "WrongDefault.msg:2: 'int32 x seven': InvalidValue"),
        ("Everythin", "msg", "cell_io has no msg 'Everythin'; nearest: Everything"),
        ("Single", "srv", "Single.srv: has 1 parts; expected 2, with lines `---` between them"),
    ],
)
def test_a_mistake_in_a_file_is_said_with_its_line(made: None, name: str, folder: str, problem: str) -> None:
    with pytest.raises(Ros2Error, match=problem):
        import_type(f"cell_io/{folder}/{name}", folder)


@pytest.mark.parametrize("is_installed", [False, True])
def test_an_installed_package_wins_and_a_folder_on_the_path_is_none(
    interfaces: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, is_installed: bool
) -> None:
    interfaces({"bay_io/msg/Point.msg": "float64 x"})
    (tmp_path / "elsewhere" / "bay_io" / "msg").mkdir(parents=True)
    for folder in ("bay_io", "bay_io/msg") if is_installed else ():
        (tmp_path / "elsewhere" / folder / "__init__.py").write_text("Point = 'installed'\n")
    monkeypatch.syspath_prepend(tmp_path / "elsewhere")
    assert (import_type("bay_io/msg/Point", "msg") == "installed") is is_installed
