"""Types of optional fields of a `Testbench`, such as `VirtualTime` and `People`: frozen dataclasses with defaults."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from pytest_hricdv._base.message import nearest
from pytest_hricdv.declarations.bystander import Bystander
from pytest_hricdv.declarations.film import Film
from pytest_hricdv.generate.context import PSEUDORANDOM_LENGTHS
from pytest_hricdv.generate.qlearning import QLearning
from pytest_hricdv.monitor.node import Kind
from pytest_hricdv.online.declaration import InteractiveAgent
from pytest_hricdv.runtime.blocking_calls import KINDS

ENDINGS = ("limit", "idle", "early", "cycle")
"""The values of `VirtualTime.allowed_endings`."""


@dataclass(frozen=True)
class VirtualTime:
    """How the code under test waits, and how its runs may end.

    Args:
        apis: the blocking APIs that the code under test uses: "time" (`time` and `datetime`), "threading" (`threading`,
            `queue`, the thread pool of `concurrent.futures`), "asyncio". They use virtual time in its modules, and its
            threads are nodes. Waiting with another API is an error.
        stall_timeout_s: processor time that code may use while simulated time stands still (s; None: 8). A second of
            simulated time may take 7.5 times as long. Beyond that, the run ends and names the line of that code.
        allowed_endings: how a run may end other than by `kernel.stop`; any other ending fails its test: "limit" (at its
            time limit), "idle" (nothing is left to do), "early" (the code under test returns before the run ends),
            "cycle" (a livelock: the run repeats itself for 180 s, and ends unless "cycle" or "limit" is allowed).
    """

    apis: tuple[str, ...] = ()
    stall_timeout_s: float | None = None
    allowed_endings: tuple[str, ...] = ()

    def faults(self) -> Iterator[str]:
        """Mistakes in the declaration."""
        for name in self.apis if isinstance(self.apis, tuple) else ():  # anything else is of a wrong type
            if name not in KINDS:
                listed = "; ".join(f'"{api}" for {modules}' for api, modules in KINDS.items())
                yield f"time: apis has {name!r}; expected a tuple of these: {listed}"
        timeout_s = self.stall_timeout_s
        is_time = isinstance(timeout_s, int | float) and not isinstance(timeout_s, bool)
        if timeout_s is not None and not (is_time and 0 < timeout_s < math.inf):
            yield f"time: stall_timeout_s is {timeout_s!r}; expected a time in seconds, above 0"
        for ending in self.allowed_endings if isinstance(self.allowed_endings, tuple) else ():
            if ending not in ENDINGS:
                expected = f"expected of {', '.join(ENDINGS)}{nearest(ending, ENDINGS)}"
                yield f"time: allowed_endings has {ending!r}; {expected}"


@dataclass(frozen=True)
class Timing:
    """How slow the code under test may be, for runs with schedules (`--hri-schedules`).

    Args:
        slowest_s: longest delay of a node at one statement (s), as on a busy machine. If it is given, a requirement
            that is violated only because of such a delay fails; None: 0.05 s, and such a violation is only listed.
    """

    slowest_s: float | None = None

    def faults(self) -> Iterator[str]:
        """Mistakes in the declaration."""
        slowest_s = self.slowest_s
        is_time = isinstance(slowest_s, int | float) and not isinstance(slowest_s, bool)
        if slowest_s is not None and not (is_time and 0 < slowest_s < math.inf):
            yield f"timing: slowest_s is {slowest_s!r}; expected a time in seconds, above 0"


@dataclass(frozen=True)
class Simulation:
    """How the world is simulated and filmed.

    Args:
        fidelities: names of the ways to simulate the world, from which `--hri-fidelity` chooses; empty if there is one.
        engines: physics engines that `run` can use: name of the engine's package -> module that is imported before the
            first test, whose ImportError says what to install; empty for an engine of your own without a package. The
            first installed engine is used unless `--hri-engine` chooses another one.
        engine_tolerances: requirement -> how much its margins may differ between engines, in the margin's unit. Within
            it, the report explains a verdict that depends on the engine by the engines' tolerance.
        requires: modules that `run` imports, such as a simulator. They are imported before the first test, so that a
            missing one is reported once and not by every test.
        film: how runs are filmed; None if they are not.
    """

    fidelities: tuple[str, ...] = ()
    engines: Mapping[str, str] = field(default_factory=dict, hash=False)
    engine_tolerances: Mapping[str, float] = field(default_factory=dict, hash=False)
    requires: tuple[str, ...] = ()
    film: Film | None = None
    fidelity: str = field(default="", init=False)
    """The session's choice, which `run` reads as `Run.fidelity`; empty if the testbench decides."""
    engine: str = field(default="", init=False)
    """The engine in use, which `run` reads as `Run.engine`; empty if there are none."""

    def choose(self, *, fidelity: str | None = None, engine: str | None = None) -> Simulation:
        """The simulation with this fidelity or engine; None keeps the current one."""
        chosen = copy.copy(self)
        for name, value in (("fidelity", fidelity), ("engine", engine)):
            if value is not None:
                object.__setattr__(chosen, name, value)
        return chosen


@dataclass(frozen=True)
class People:
    """Actors that decide during the run, and actors without a model.

    Args:
        agents: the agents of the model that can decide during a run what people do, one for each actor; empty if all
            actions are known before the run.
        bystanders: actors without a model, such as a dog: `Bystander("dog", {"walk": {...}})`. A node of the world
            reads the dog's actions from `run.actions("dog")`.
    """

    agents: tuple[InteractiveAgent, ...] = ()
    bystanders: tuple[Bystander, ...] = ()


@dataclass(frozen=True)
class Suites:
    """The settings of generated suites.

    Args:
        by_hand: TOML file of belief subsets for the suite `by-hand`; None if there is none.
        learning: the constants of Q-learning, for the suite `rl`.
        random_test_length: least and greatest number of actions of a test of the suite `pseudorandom`, for each actor.
    """

    by_hand: Path | None = None
    learning: QLearning = field(default_factory=QLearning)
    random_test_length: tuple[int, int] = PSEUDORANDOM_LENGTHS


@dataclass(frozen=True)
class StateField:
    """Where the code under test publishes its state.

    Args:
        name: the string field of a message, such as "state.name"; empty if there is none.
        transitions: pairs of successive states that the suite `closure` has to cover.
    """

    name: str = ""
    transitions: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Signal:
    """A physical signal that the world records; a bare type, such as bool, declares one without anything else.

    Args:
        type: bool, float or str.
        unit: the unit of a float, for instance "m/s". Reports show it, and numbers in requirements may have a unit, too
            (`hand_distance < 50 mm`).
        values: all values of a str. A requirement that compares it with another string is refused.
        sampled_while: a bool signal. The world measures this signal only while that one is True; otherwise, plots have
            a gap, and requirements use the last value.
    """

    type: Kind
    unit: str = ""
    values: tuple[str, ...] = ()
    sampled_while: str = ""


@dataclass(frozen=True)
class Field:
    """Facts about a field that the class of its message does not state.

    Args:
        unit: the unit of a number, as for `Signal`.
        values: all values of a string, as for `Signal`; not needed for Literal and Enum.
    """

    unit: str = ""
    values: tuple[str, ...] = ()
