"""asyncio in virtual time: Python's own event loop, and more than one of them in a process."""

from __future__ import annotations

import asyncio
import contextlib
import gc
import re
from collections.abc import AsyncIterator, Callable, Coroutine
from typing import Any

import numpy as np
import pytest

from pytest_hricdv.runtime import Kernel, NodeError
from pytest_hricdv.runtime.virtual import asyncio_functions, event_loop, thread_pool, threads

VIRTUAL: Any = asyncio_functions.MODULES[0]
THREADING: Any = threads.MODULES[0]
FUTURES: Any = thread_pool.MODULES[0]


def stopping(at_s: float) -> Callable[[Kernel], None]:
    """A node that ends the run at this time."""

    def body(kernel: Kernel) -> None:
        kernel.sleep(at_s)
        kernel.stop("done")

    return body


def run(*bodies: Callable[[Kernel], object], kinds: tuple[str, ...] = ("time", "threading", "asyncio")) -> Kernel:
    """Run nodes to their end."""
    kernel = Kernel()
    kernel.virtual = frozenset(kinds)
    for number, body in enumerate(bodies):
        kernel.spawn(f"node {number}", lambda body=body: body(kernel))  # type: ignore[misc]
    try:
        kernel.run(1000.0)
    finally:
        kernel.close()
    return kernel


def test_coroutines_wait_in_virtual_time() -> None:
    said: list[object] = []

    async def tick(kernel: Kernel, number: int, period_s: float) -> None:
        for _ in range(number):
            await asyncio.sleep(period_s)
            said.append((period_s, kernel.now_s))

    async def main(kernel: Kernel) -> str:
        jobs: asyncio.Queue[int] = asyncio.Queue()
        asyncio.get_running_loop().call_later(5.0, jobs.put_nowait, 7)
        await asyncio.gather(tick(kernel, 2, 1.0), tick(kernel, 3, 0.7))
        with pytest.raises(TimeoutError):
            await asyncio.wait_for(asyncio.Event().wait(), 0.4)
        said.append(kernel.now_s)
        async with asyncio.timeout(100):
            said.append((await jobs.get(), kernel.now_s, asyncio.get_running_loop().time()))
        return "result"

    run(lambda kernel: said.append(VIRTUAL.run(main(kernel))))
    assert said == [(0.7, 0.7), (1.0, 1.0), (0.7, 1.4), (1.0, 2.0), (0.7, 2.1), 2.5, (7, 5.0, 5.0), "result"]


@pytest.mark.parametrize(("start_s", "delay_s"), [(0.0, 1e-14), (0.0, 9e-7), (900.0, 1e-10), (900.0, 9e-7)])
def test_time_outs_of_less_than_the_resolution_let_time_pass(start_s: float, delay_s: float) -> None:
    async def main() -> None:
        loop = asyncio.get_running_loop()
        for wait in (
            lambda: asyncio.wait_for(asyncio.Event().wait(), delay_s),
            lambda: asyncio.wait([asyncio.ensure_future(asyncio.sleep(1.0))], timeout=delay_s),
            lambda: asyncio.sleep(delay_s),
        ):
            end_s = loop.time() + 1e-5
            while loop.time() < end_s:
                with contextlib.suppress(TimeoutError):
                    await wait()

    def body(kernel: Kernel) -> None:
        kernel.sleep(start_s)
        VIRTUAL.run(main())

    assert run(body).now_s == pytest.approx(start_s + 3e-5, abs=1e-5)


def test_nodes_have_loops_of_their_own_and_a_coroutine_may_block() -> None:
    said: list[object] = []

    async def numbers() -> AsyncIterator[int]:
        for number in range(2):
            await asyncio.sleep(1.0)
            yield number

    def body(name: str) -> Callable[[Kernel], object]:
        async def main(kernel: Kernel) -> None:
            async for number in numbers():
                kernel.sleep(0.25)  # blocks the whole loop, as it does in real time
                task = asyncio.current_task()
                assert task is not None
                said.append((name, number, kernel.now_s))
            await asyncio.to_thread(kernel.sleep, 1.0)
            said.append((name, kernel.now_s))

        return lambda kernel: VIRTUAL.run(main(kernel))

    run(body("a"), body("b"))
    expected = [(0, 1.25), (1, 2.5)]
    assert said == [
        *((name, *step) for step in expected for name in "ab"),
        ("a", 3.5),
        ("b", 3.5),
    ]


def test_a_loop_in_a_thread_is_given_work_by_others() -> None:
    said: list[object] = []

    async def work(kernel: Kernel) -> float:
        await asyncio.sleep(4.0)
        return kernel.now_s

    def body(kernel: Kernel) -> None:
        loop = VIRTUAL.new_event_loop()
        thread = THREADING.Thread(target=loop.run_forever)
        thread.start()
        said.append(VIRTUAL.run_coroutine_threadsafe(work(kernel), loop).result(timeout=5.0))
        late = VIRTUAL.run_coroutine_threadsafe(work(kernel), loop)
        with pytest.raises(TimeoutError):
            late.result(timeout=1.0)
        said.append(kernel.now_s)
        loop.call_soon_threadsafe(loop.stop)
        thread.join()
        said.append(late.done())
        loop.close()  # otherwise it is closed whenever it is collected, during whichever test

    run(body)
    gc.collect()  # asyncio says here, and not in another test, that a task was left
    assert said == [4.0, 5.0, False]


@pytest.mark.parametrize("waits_in", ["sleep", "queue"])
def test_a_program_that_is_cut_off_cancels_its_tasks_without_a_word(
    waits_in: str, capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    async def serve(orders: asyncio.Queue[str]) -> None:
        while True:
            await (orders.get() if waits_in == "queue" else asyncio.sleep(10_000.0))

    async def main() -> None:
        serving = asyncio.create_task(serve(asyncio.Queue()))
        try:
            async with asyncio.timeout(10_000.0):
                await asyncio.Event().wait()
        finally:
            serving.cancel()

    run(lambda kernel: VIRTUAL.run(main()))
    gc.collect()
    assert capfd.readouterr() == ("", "")
    assert caplog.messages == []


def test_what_is_ensured_before_a_loop_runs_runs_in_that_of_the_node() -> None:
    done: list[float] = []

    async def work(kernel: Kernel) -> None:
        await asyncio.sleep(2.0)
        done.append(kernel.now_s)
        asyncio.get_running_loop().stop()

    def body(kernel: Kernel) -> None:
        VIRTUAL.ensure_future(work(kernel))
        VIRTUAL.get_event_loop().run_forever()
        VIRTUAL.get_event_loop().close()

    run(body)
    assert done == [2.0]


def test_outside_of_a_node_it_is_asyncio_itself() -> None:
    async def main() -> str:
        return type(asyncio.get_running_loop()).__name__

    assert VIRTUAL.run(main()) != event_loop.VirtualEventLoop.__name__


@pytest.mark.parametrize(
    "wait",
    [lambda: asyncio.create_subprocess_exec("true"), lambda: asyncio.open_connection("127.0.0.1", 9)],
    ids=["process", "socket"],
)
def test_what_is_outside_of_the_run_is_refused(wait: Callable[[], Coroutine[Any, Any, object]]) -> None:
    async def main() -> None:
        await wait()

    with pytest.raises(NodeError, match=r"test_event_loop.py:\d+: node .+ waits in real time, in asyncio's"):
        run(lambda kernel: VIRTUAL.run(main()), kinds=("time", "asyncio"))


def test_a_loop_that_never_waits_is_ended() -> None:
    async def main() -> None:
        while True:
            await asyncio.sleep(0)

    line = main.__code__.co_firstlineno + 2
    with pytest.raises(NodeError, match=rf"polls without time passing, at {re.escape(__file__)}:{line}: a loop must"):
        run(lambda kernel: VIRTUAL.run(main()))


async def fail(after_s: float) -> None:
    """Ends with an error."""
    await asyncio.sleep(after_s)
    raise ValueError("lost in a task")


class TestErrorsThatNobodyTakes:
    LOST = "a task of asyncio, fail, raised ValueError: lost in a task at "

    def lost(self, main: Callable[[], Coroutine[Any, Any, object]]) -> list[str]:
        """What a run says of them."""
        return run(lambda kernel: VIRTUAL.run(main())).lost_errors

    def test_are_told_when_the_loop_is_closed(self) -> None:
        async def main() -> None:
            task = asyncio.create_task(fail(0.1))
            await asyncio.sleep(1.0)
            assert task.done()

        (said,) = self.lost(main)
        assert said.startswith(self.LOST + __file__)
        assert said.endswith(", and nothing awaited it: await the task, or use asyncio.TaskGroup")
        assert self.lost(main) == [said]  # whatever number asyncio gives it

    def test_have_the_name_that_their_author_gave_the_task(self) -> None:
        async def main() -> None:
            task = asyncio.create_task(fail(0.1), name="lift watch")
            await asyncio.sleep(1.0)
            assert task.done()

        assert self.lost(main)[0].startswith("a task of asyncio, lift watch, raised ")

    def test_are_told_of_a_loop_that_goes_on_when_the_run_ends(self) -> None:
        async def main() -> None:
            task = asyncio.create_task(fail(0.1))
            while True:
                await asyncio.sleep(1.0)
                assert task.done()

        kernel = run(lambda kernel: VIRTUAL.run(main()), stopping(5.0))
        assert [text.startswith(self.LOST) for text in kernel.lost_errors] == [True]

    @pytest.mark.parametrize("ends_s", [0.5, 50.0], ids=["the run ends before", "to its end"])
    def test_are_none_that_somebody_takes(self, ends_s: float) -> None:
        async def main() -> None:
            await asyncio.gather(fail(0.1), asyncio.sleep(10.0), return_exceptions=True)
            done, _ = await asyncio.wait([asyncio.create_task(fail(0.1)), asyncio.create_task(asyncio.sleep(10.0))])
            assert [task.exception() is None for task in done].count(False) == 1

        def body(kernel: Kernel) -> None:
            VIRTUAL.run(main())

        for start_s in (0.0, 10.0):
            kernel = run(body, stopping(start_s + ends_s))
            assert kernel.lost_errors == []

    def test_are_none_that_are_awaited_late_or_cancelled_or_handled(self) -> None:
        async def two_at_once() -> None:
            async with asyncio.TaskGroup() as group:
                group.create_task(fail(0.1))
                group.create_task(fail(0.1))

        async def main() -> None:
            late, gone = asyncio.create_task(fail(0.1)), asyncio.create_task(fail(9.0))
            await asyncio.sleep(1.0)
            gone.cancel()
            with pytest.raises(ValueError, match="lost"):
                await late
            with pytest.raises(ExceptionGroup):
                await two_at_once()

        assert self.lost(main) == []

    @pytest.mark.parametrize("schedule", ["call_soon", "call_later", "add_done_callback"])
    def test_are_told_of_callbacks(self, schedule: str) -> None:
        def callback(*_: object) -> None:
            raise ValueError("lost in a callback")

        async def main() -> None:
            loop = asyncio.get_running_loop()
            if schedule == "call_soon":
                loop.call_soon(callback)
            elif schedule == "call_later":
                loop.call_later(0.5, callback)
            else:
                asyncio.create_task(asyncio.sleep(0.1)).add_done_callback(callback)
            await asyncio.sleep(1.0)

        (said,) = self.lost(main)
        assert said.startswith(f"a callback of asyncio raised ValueError: lost in a callback at {__file__}:")
        assert "the event loop continued" in said

    def test_are_none_where_the_program_handles_those_of_callbacks(self) -> None:
        handled: list[object] = []

        async def main() -> None:
            loop = asyncio.get_running_loop()
            loop.set_exception_handler(lambda _, context: handled.append(context["exception"]))
            loop.call_soon(lambda: 1 / 0)
            await asyncio.sleep(1.0)

        assert self.lost(main) == []
        assert [type(error) for error in handled] == [ZeroDivisionError]

    @pytest.mark.parametrize("is_awaited", [False, True])
    def test_are_told_of_calls_in_an_executor(self, is_awaited: bool) -> None:
        async def main() -> None:
            future = asyncio.get_running_loop().run_in_executor(None, lambda: 1 / 0)
            await asyncio.sleep(1.0)
            if is_awaited:
                with pytest.raises(ZeroDivisionError):
                    await future

        kernel = run(lambda kernel: VIRTUAL.run(main()))
        said = [*kernel.lost_errors, *filter(None, (lost_error() for lost_error in kernel.unclaimed))]
        assert [text.startswith("a call in asyncio's run_in_executor raised Zero") for text in said] == (
            [] if is_awaited else [True]
        )

    @pytest.mark.parametrize("take", ["nobody", "result", "exception", "map", "wait", "callback"])
    def test_are_told_of_calls_in_a_thread_pool(self, take: str) -> None:
        def fail_there(number: int) -> None:
            raise ValueError(number)

        def body(kernel: Kernel) -> None:
            with FUTURES.ThreadPoolExecutor(2) as pool:
                if take == "map":
                    with pytest.raises(ValueError, match="1"):
                        list(pool.map(fail_there, [1]))
                    return
                future = pool.submit(fail_there, 1)
                if take == "callback":
                    future.add_done_callback(lambda done: done.exception())
                kernel.sleep(1.0)
            if take == "result":
                with pytest.raises(ValueError, match="1"):
                    future.result()
            elif take == "exception":
                assert isinstance(future.exception(), ValueError)
            elif take == "wait":
                assert FUTURES.wait([future]).done == {future}  # done, and nobody looked how

        kernel = run(body)
        said = [lost_error() for lost_error in kernel.unclaimed]
        if take in ("nobody", "wait"):
            assert said[0].startswith(f"a call in a ThreadPoolExecutor raised ValueError: 1 at {__file__}:")
        else:
            assert not any(said)


def test_a_loop_that_an_exit_ends_leaves_nothing_to_say_to_the_garbage_collector(
    caplog: pytest.LogCaptureFixture,
) -> None:
    """What asyncio says of a task formats its traceback, which breaks a parse of Python 3.11 that goes on then."""

    async def leave() -> None:
        raise SystemExit(3)

    async def main() -> None:
        async with asyncio.TaskGroup() as group:
            group.create_task(leave())

    def body(kernel: Kernel) -> None:
        with pytest.raises(SystemExit):
            VIRTUAL.run(main())

    run(body)
    gc.collect()
    assert not caplog.records


def test_a_delay_may_be_any_number_that_adds_to_a_time() -> None:
    seen: list[float] = []

    def body(kernel: Kernel) -> None:
        delay_s: Any = np.float32(0.25)
        VIRTUAL.run(asyncio.sleep(delay_s))
        seen.append(round(kernel.now_s, 3))

    run(body)
    assert seen == [0.25]


def test_what_is_no_coroutine_is_refused_as_by_asyncio() -> None:
    refused: list[type] = []

    def body(kernel: Kernel) -> None:
        try:
            VIRTUAL.run(3)
        except Exception as error:
            refused.append(type(error))

    run(body)
    with pytest.raises(refused[0]):
        asyncio.run(3)  # type: ignore[arg-type]
