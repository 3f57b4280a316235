"""Where code is, as messages say it: the line of its author, not of a library."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from types import FrameType, SimpleNamespace
from typing import Any

import pytest

from pytest_hricdv.runtime import Kernel, KernelError
from pytest_hricdv.runtime.source_location import error_line, place_of

HERE = Path(__file__).name


def where(*_: object) -> str:
    return place_of(sys._getframe(1))


def test_it_is_a_line_of_the_author() -> None:
    assert where().rpartition(":")[0].endswith(HERE)


def test_libraries_are_passed_over() -> None:
    hidden: dict[str, Any] = {"__name__": "library", "__tracebackhide__": True, "where": where}
    exec("def call():\n    return where()\n", hidden)
    line = sys._getframe().f_lineno
    places = [json.loads("{}", object_hook=where), hidden["call"]()]
    assert [place.rpartition(":")[2] for place in places] == [str(line + 1), str(line + 1)]


def test_a_thread_that_runs_a_library_has_the_line_that_began_it_or_that_of_the_library() -> None:
    def frame(module: str, back: FrameType | None = None) -> Any:
        code = SimpleNamespace(co_filename=f"{module}.py", co_name="call")
        return SimpleNamespace(f_globals={"__name__": module}, f_code=code, f_lineno=7, f_back=back, f_locals={})

    pool = frame("pytest_hricdv.runtime.virtual.thread_pool")
    assert place_of(frame("pytest_hricdv.runtime.virtual.real_time", frame("subprocess", pool))) == "subprocess.py:7"
    assert place_of(pool) == "an unknown place"
    pool.f_locals["self"] = SimpleNamespace(begun_at="arm.py:3")
    assert place_of(frame("pytest_hricdv.runtime.virtual.real_time", frame("subprocess", pool))) == "arm.py:3"


def test_what_pytest_raises_is_at_the_line_that_called_it() -> None:
    with pytest.raises(pytest.skip.Exception) as raised:
        pytest.skip("not here")
    assert error_line(raised.value).rpartition(":")[0].endswith(HERE)


def busy(kernel: Kernel) -> None:
    while True:
        pass


def polls(kernel: Kernel) -> None:
    while True:
        kernel.count_poll()


@pytest.mark.parametrize("body", [busy, polls])
def test_a_node_that_keeps_time_from_passing_is_said_with_its_line(
    body: Callable[[Kernel], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pytest_hricdv.runtime.kernel.STUCK_AFTER_S", 0.1)
    kernel = Kernel(max_resumes_at_one_instant=100)
    kernel.spawn("arm", lambda: body(kernel))
    first = body.__code__.co_firstlineno
    with pytest.raises(KernelError, match=rf", at \S+{HERE}:({first + 1}|{first + 2})(: a loop must sleep)?; in arm"):
        kernel.run(1.0)
    kernel.close()
