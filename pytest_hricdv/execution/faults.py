"""Faults of a run besides its requirements. A run with a fault fails its test, and keeps its verdicts and files.

A node that fails, a run that reaches its time limit, code under test that returns while its world continues, a bin that
cannot or must not be hit: without faults, each would look like a run with unchecked requirements. `case.execute` gives
each run a `CodeUnderTest`, and calls the `check_*` functions after it; each yields its faults as sentences.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from types import FrameType

from pytest_hricdv._base.error_text import causes, error_text
from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.monitor import Verdict
from pytest_hricdv.run_course import INSTANT_S
from pytest_hricdv.runtime import Kernel, KernelError, Node, NodeError
from pytest_hricdv.testbench import Ending, Outcome, Testbench

Body = Callable[[], None]  # the function that a node runs

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too


class CodeUnderTest:
    """The nodes of the code under test: when they returned, and what one of them raised.

    Args:
        measured: wraps the body of a node, so that it is measured.
    """

    def __init__(self, kernel: Kernel, measured: Callable[[Body], Body]) -> None:
        self._kernel = kernel
        self._measured = measured
        self._returned_s: list[float | None] = []
        self._nodes: list[Node] = []
        self.raised: BaseException | None = None

    @property
    def now_s(self) -> float:
        """The simulated time (s)."""
        return self._kernel.now_s

    def node(self, body: Body) -> Body:
        """The body of a node of the code under test, measured; its threads are part of the code, too."""
        return self._thread(body, daemon=False)

    def _thread(self, body: Body, daemon: bool) -> Body:
        measured, number = self._measured(body), len(self._returned_s)
        self._returned_s.append(0.0 if daemon else None)  # the code is over when all but such threads are

        def observe() -> None:
            node = self._kernel.current()
            node.wrap_thread = self._thread
            self._nodes.append(node)
            try:
                measured()
            except BaseException as error:
                self.raised = error
                raise
            if not daemon:
                self._returned_s[number] = self._kernel.now_s

        return observe

    @property
    def has_run(self) -> bool:
        """Whether it has had a node. Code that runs elsewhere, as in the world or the person, is not measured."""
        return bool(self._nodes)

    @property
    def threads(self) -> int:
        """How many nodes it has had, threads and nodes of ROS 2, and tasks of asyncio except the first."""
        return len(self._nodes) + sum(node.tasks for node in self._nodes)

    def is_running(self) -> bool:
        """Whether the caller is one of its nodes."""
        return self.has(self._kernel.own_node())

    def has(self, node: Node | None) -> bool:
        """Whether a node is one of its; None for none."""
        return node in self._nodes

    def is_other_running(self) -> bool:
        """Whether the caller is a node other than its own, such as a person; the kernel and the world are not nodes."""
        node = self._kernel.own_node()
        return node is not None and node not in self._nodes

    @property
    def wait_frames(self) -> Mapping[str, FrameType]:
        """Its nodes that wait -> their innermost frames."""
        frames = {node.name: node.frame for node in self._nodes}
        return {name: frame for name, frame in frames.items() if frame is not None}

    @property
    def last_return_s(self) -> float | None:
        """When the last of its nodes returned (s of simulated time); None if one did not, or there is none."""
        times = [time_s for time_s in self._returned_s if time_s is not None]
        return max(times) if times and len(times) == len(self._returned_s) else None


def check_ending(ending: Ending, code: CodeUnderTest, allowed: tuple[str, ...]) -> Iterator[str]:
    """Faults of how a run ended, a sentence each.

    Args:
        allowed: see `VirtualTime.allowed_endings`.
    """
    if ending.error is not None:
        yield _failure(ending.error, code)
        return
    allow = "if it may, declare VirtualTime(allowed_endings="
    early_s = code.last_return_s
    if early_s is not None and early_s < ending.time_s and "early" not in allowed:
        went_on = f"and the run continued to {ending.time_s:.3f} s"
        yield f'the code under test returned at {early_s:.3f} s, {went_on}; {allow}("early",))'
    if ending.how == "limit" and "limit" not in allowed:
        yield f'the run ended at its time limit of {ending.time_s:g} s; {allow}("limit",))'
    if ending.cycle is not None:
        yield f'livelock: {ending.cycle}; {allow}("cycle",))'
    if ending.how == "idle" and "idle" not in allowed:
        yield f'the run ended at {ending.time_s:.3f} s because nothing was left to do; {allow}("idle",))'


def check_actors(idle: Iterable[str]) -> Iterator[str]:
    """Faults of actors whose actions nobody took, a sentence each."""
    for actor in idle:
        yield (
            f"no node enacts the actions of {actor}: expected a node of the testbench's run that takes "
            f"run.actions({actor!r})"
        )


def check_simulation(kernel: Kernel, ending: Ending | None) -> Iterator[str]:
    """Faults of the simulation, a sentence each: nothing was simulated, or threads outside the run took part."""
    yield from kernel.trespasses
    yield from kernel.lost_errors
    yield from _caught_refusals(kernel, ending)
    yield from filter(None, (lost_error() for lost_error in kernel.unclaimed))
    if ending is not None and ending.error is not None:
        return  # the failure says more
    had_nothing_to_do = ending is not None and ending.how == "idle" and ending.time_s <= INSTANT_S
    if kernel.now_s > INSTANT_S and not had_nothing_to_do:
        return
    why = "" if ending is not None else ", as the testbench's run never called run.go"
    yield (
        f"the run simulated nothing: no simulated time passed{why}, so its verdicts are of the first instant only; "
        "spawn nodes that wait with the clock of run.kernel, or in virtual time, and call run.go(limit_s)"
    )


def _caught_refusals(kernel: Kernel, ending: Ending | None) -> Iterator[str]:
    """Refusals whose error the code caught before it continued: its behaviour after that means nothing."""
    raised = () if ending is None else causes(ending.error)
    told = {str(error) for error in raised if isinstance(error, KernelError)}
    for text in dict.fromkeys(map(str, kernel.refusals)):
        if text not in told:
            yield f"{text}. The code caught this error and continued"


def _failure(error: NodeError, code: CodeUnderTest) -> str:
    raised = error.__cause__
    if raised is None:
        return f"node {error}"
    description = error_text(raised)
    if raised is code.raised:
        return f"the code under test raised {description} in node {error.node} at {error.time_s:.3f} s"
    return f"node {error.node} raised {description} at {error.time_s:.3f} s"


def check_bins(
    testbench: Testbench, outcome: Outcome, verdicts: tuple[Verdict, ...]
) -> tuple[dict[str, tuple[Bin, ...]], list[str]]:
    """The bins that a run hit, by cross product, and what is wrong with them, a sentence each."""
    judged: Mapping[str, str] = {verdict.requirement: verdict.verdict for verdict in verdicts}
    declared = ", ".join(testbench.cross) or "none"
    unknown = sorted(outcome.cross.keys() - testbench.cross.keys())
    faults = [f"cross product: run reported bins of {name!r}, but declared are: {declared}" for name in unknown]
    hits = {}
    for name, product in testbench.cross.items():
        checked = product.check(outcome.cross.get(name, ()), judged)
        hits[name] = checked.bins
        faults += [f"cross product {name!r}: {fault}" for fault in checked.faults]
    return hits, faults
