"""`Testbench`: what a project gives to the plugin in `pytest_hricdv_testbench`: what to generate, run and require."""

from __future__ import annotations

import collections.abc
import dataclasses
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, get_args, get_origin, get_type_hints

from pytest_hricdv.coupling.percept_mapping import PerceptMapping
from pytest_hricdv.coverage.cross_product import Bin, CrossProduct
from pytest_hricdv.declarations.bystander import Bystander
from pytest_hricdv.declarations.film import Camera, Film
from pytest_hricdv.declarations.model_oracle import ActionMapping, ModelOracle, ModelOracleError
from pytest_hricdv.declarations.ros2 import Launch, Ros2, RosNode
from pytest_hricdv.disturbance import Delay, Disturbance, Disturbances, Drop, Duplicate, lines
from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.beliefs import BeliefSpace
from pytest_hricdv.generate.concrete import Concretization
from pytest_hricdv.generate.model import Model
from pytest_hricdv.generate.qlearning import QLearning
from pytest_hricdv.generate.sampler import Constant, Sampler, Sometimes, Uniform
from pytest_hricdv.monitor import Requirement, Vocabulary
from pytest_hricdv.monitor.node import Kind
from pytest_hricdv.online.declaration import InteractiveAgent, InteractiveAgentError
from pytest_hricdv.registry import offers
from pytest_hricdv.run import Ending, Run, TestbenchError
from pytest_hricdv.runtime import fields_of, text_of, topic_of
from pytest_hricdv.runtime.world import Body
from pytest_hricdv.testbench_groups import Field, People, Signal, Simulation, StateField, Suites, Timing, VirtualTime

_KINDS: tuple[Kind, ...] = (bool, float, str)

_COLLECTIONS = (
    bytes, bytearray, list, tuple, set, frozenset, dict, collections.deque, collections.abc.Sequence,
    collections.abc.Mapping, collections.abc.Set,
)  # fmt: skip
"""Types that a record stores as length and checksum (see `pytest_hricdv.runtime.message_fields`)."""

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too

__all__ = [
    "ActionMapping",
    "BeliefSpace",
    "Body",
    "Bystander",
    "Camera",
    "Concretization",
    "Constant",
    "CrossProduct",
    "Delay",
    "Disturbance",
    "Drop",
    "Duplicate",
    "Ending",
    "Field",
    "Film",
    "GenerateError",
    "InteractiveAgent",
    "InteractiveAgentError",
    "Launch",
    "Model",
    "ModelOracle",
    "ModelOracleError",
    "Outcome",
    "People",
    "PerceptMapping",
    "QLearning",
    "Ros2",
    "RosNode",
    "Run",
    "Sampler",
    "Signal",
    "Simulation",
    "Sometimes",
    "StateField",
    "Suites",
    "Testbench",
    "TestbenchError",
    "Timing",
    "Uniform",
    "VirtualTime",
]

FIELD_PURPOSES: Mapping[str, str] = {
    "name": "a name for reports",
    "model": "the BDI model (Model) that tests are generated from",
    "beliefs": "the belief space (BeliefSpace) that steers the model",
    "concretization": "the human's commands with the ranges of their parameters (Concretization)",
    "requirements": "the path of a TOML file of requirement texts, or a tuple of requirements",
    "messages": "the classes of the messages on the bus: dataclasses, or the like",
    "signals": "the physical signals, name -> bool, float, str or Signal(...)",
    "cross": "a mapping of names to cross products (CrossProduct)",
    "code": "the names of the packages under test",
    "run": "a function that runs one concrete test and returns an Outcome",
}


def comparable_fields(
    message: type[object], above: str = "", inside: tuple[type[object], ...] = ()
) -> Iterator[tuple[str, Kind, tuple[str, ...]]]:
    """The fields that requirements can compare: name, type, and all possible strings where the type lists them.

    Fields of a nested message are named by path; a list has the fields `length` and `crc`. What may be None is left
    out.

    Args:
        message: the class.
        above: path of the field that contains it, with a dot at the end.
        inside: the classes that contain it, so that a recursive class ends.
    """
    hints = get_type_hints(message)
    for name in fields_of(message) or ():
        hint, path = hints.get(name), above + name
        kind, texts = _field_type(hint)
        if kind is not None:
            yield path, kind, texts
        elif isinstance(hint, type) and fields_of(hint) is not None and hint not in inside:
            yield from comparable_fields(hint, f"{path}.", (*inside, message))
        elif (get_origin(hint) or hint) in _COLLECTIONS:
            yield f"{path}.length", float, ()
            yield f"{path}.crc", float, ()


def _field_type(hint: object) -> tuple[Kind | None, tuple[str, ...]]:
    """The type of a field in requirements, None if they cannot compare it; all possible strings if the type lists
    them."""
    if isinstance(hint, type) and issubclass(hint, Enum):
        return str, tuple(map(text_of, hint))
    if get_origin(hint) is Literal:
        values = tuple(text_of(value) if isinstance(value, Enum) else value for value in get_args(hint))
        types = {type(value) for value in values}
        hint = types.pop() if len(types) == 1 else None
        return (str, values) if hint is str else _field_type(hint)
    return float if hint is int else next((kind for kind in _KINDS if hint is kind), None), ()


@dataclass(frozen=True)
class Outcome:
    """How a run went, in the testbench's own words.

    Args:
        ended: why it ended, for instance "table done".
        outcomes: how each interaction ended, in order.
        skipped_s: simulated seconds for which the physics was not stepped.
        cross: name of a cross product -> the bins that the run hit, as tuples of one value per coordinate, except
            coordinates named after a requirement.
        fidelity: how the world was simulated, if there are several ways; every report shows it.

    Raises:
        TestbenchError: a string is not one, or `skipped_s` is not a time.

    A run with two interactions. The cross product `rides` has the coordinates rider, floor and R1: the values of the
    first two are reported, in their order, and that of R1 is its verdict (see `CrossProduct`).

    >>> outcome = Outcome(
    ...     "all are where they wanted to go",
    ...     outcomes=("carried", "refused"),
    ...     cross={"rides": [("nurse", "ward"), ("child", "roof")]},
    ... )
    >>> outcome.cross["rides"][0]
    ('nurse', 'ward')
    """

    ended: str
    outcomes: tuple[str, ...] = ()
    skipped_s: float = 0.0
    cross: Mapping[str, Sequence[Bin]] = field(default_factory=dict, hash=False)
    fidelity: str = ""

    def __post_init__(self) -> None:
        for name in ("ended", "fidelity"):
            if not isinstance(getattr(self, name), str):
                raise TestbenchError(f"Outcome: {name} is {getattr(self, name)!r}; expected a string")
        if isinstance(self.outcomes, str) or not all(isinstance(outcome, str) for outcome in self.outcomes):
            raise TestbenchError(f"Outcome: outcomes is {self.outcomes!r}; expected a tuple of strings")
        if not isinstance(self.skipped_s, int | float) or not 0 <= self.skipped_s < math.inf:
            raise TestbenchError(f"Outcome: skipped_s is {self.skipped_s!r}; expected a time in seconds")


@dataclass(frozen=True)
class Testbench:
    """A robot's code, its world, and what is asked of them.

    Args:
        name: shown in reports.
        model: the BDI model that tests are generated from.
        beliefs: the belief space that steers the model.
        concretization: the commands that people can enact, with the ranges of their parameters; if the model has
            several actors, each names its actor: `nurse: press call`.
        requirements: TOML file of requirement texts, or requirements built in Python (`pytest_hricdv.monitor.build`).
        messages: the classes of the messages on the bus, frozen dataclasses for preference; named tuples and classes of
            attrs, msgspec and pydantic work as well. Fields that are bool, int, float, str, Literal or Enum
            can be named in requirements; a member of an Enum by its value if that is a string, else by its name.
        signals: physical signals that the world records: name -> bool, float or str, or `Signal(...)` with a unit, the
            possible values of a string, or when it is measured.
        fields: the units and values of fields of messages: `topic.field` -> `Field(...)`.
        code: importable names of the packages under test.
        run: builds world, human, sensors and controller for the given `Run`, runs them, and returns the outcome.
        cross: the cross products to cover, by name.
        outcome_label: the name of a run's interactions in reports, such as "legs".
        oracle: the agent of the model that each run is compared with, and how the two correspond; None if there is
            none.
        suites: what the suites of generated tests need.
        state: where the code under test publishes its state.
        people: the agents that decide during a run, and bystanders.
        time: how the code under test waits, and how its runs may end.
        timing: how slow the code may be, for runs with schedules.
        simulation: the fidelities and physics engines of the world, and how it is filmed.
        disturbances: what can go wrong, by name; a test has a line `disturb NAME` where it does. No published method
            generates such lines.
        ros2: the code under test as a ROS 2 system, `Ros2(topics={...}, ...)`; None if it is not one. Its nodes see
            "time" and "threading" in virtual time, whatever `time` says.
    """

    __test__ = False

    name: str
    model: Model
    beliefs: BeliefSpace
    concretization: Concretization
    requirements: Path | tuple[Requirement, ...]
    messages: tuple[type[Any], ...]
    signals: Mapping[str, Kind | Signal] = field(hash=False)
    code: tuple[str, ...]
    run: Callable[[Run], Outcome]
    fields: Mapping[str, Field] = field(default_factory=dict, hash=False)
    cross: Mapping[str, CrossProduct] = field(default_factory=dict, hash=False)
    outcome_label: str = "interactions"
    oracle: ModelOracle | None = None
    people: People = field(default_factory=People)
    suites: Suites = field(default_factory=Suites)
    state: StateField = field(default_factory=StateField)
    time: VirtualTime = field(default_factory=VirtualTime)
    timing: Timing = field(default_factory=Timing)
    simulation: Simulation = field(default_factory=Simulation)
    disturbances: Disturbances = field(default_factory=dict, hash=False)
    ros2: Ros2 | None = None

    @cached_property
    def commands(self) -> Concretization:
        """All commands that tests may contain: the concretization, from which methods draw, with disturbances, and
        turns if there are several actors."""
        declared = self.concretization
        if self.model.actors:
            declared = declared.with_turns(self.model.actors)
            declared = declared.with_pauses(self.model.actors) if self.people.agents else declared
        for bystander in self.people.bystanders:
            declared = dataclasses.replace(declared, run={**declared.run, **bystander.parameters})
        return dataclasses.replace(declared, commands={**declared.commands, **lines(self.disturbances)})

    @cached_property
    def signal_types(self) -> Mapping[str, Kind]:
        """Signal -> bool, float or str."""
        return {name: signal.type if isinstance(signal, Signal) else signal for name, signal in self.signals.items()}

    @cached_property
    def units(self) -> Mapping[str, str]:
        """Signal, or `topic.field` -> its unit, if it has one."""
        return {name: declared.unit for name, declared in self._details.items() if declared.unit}

    @cached_property
    def values(self) -> Mapping[str, tuple[str, ...]]:
        """Signal, or `topic.field` -> its possible values, if they are declared."""
        return {name: declared.values for name, declared in self._details.items() if declared.values}

    @cached_property
    def sampling_conditions(self) -> Mapping[str, str]:
        """Signal -> the bool signal that has to be True for the world to measure it."""
        signals = ((name, signal) for name, signal in self.signals.items() if isinstance(signal, Signal))
        return {name: signal.sampled_while for name, signal in signals if signal.sampled_while}

    @property
    def _details(self) -> Mapping[str, Signal | Field]:
        signals = {name: signal for name, signal in self.signals.items() if isinstance(signal, Signal)}
        return {**signals, **self.fields}

    def choose(self, *, fidelity: str | None = None, engine: str | None = None) -> Testbench:
        """The testbench with this fidelity or engine; None keeps the current one.

        Raises:
            TestbenchError: the simulation has no such fidelity.
        """
        fidelities = self.simulation.fidelities
        if fidelity is not None and fidelity not in fidelities:
            listed = ", ".join(fidelities) or 'none: give it simulation=Simulation(fidelities=("...", "..."))'
            raise TestbenchError(f"fidelity {fidelity!r}: testbench {self.name!r} has {listed}")
        return dataclasses.replace(self, simulation=self.simulation.choose(fidelity=fidelity, engine=engine))

    def vocabulary(self) -> Vocabulary:
        """The names that requirements may use: signals, topics, and those fields of messages that can be compared.

        Raises:
            ValueError: a name cannot be used in requirements, or is used for two messages, or both on the bus and in
                ROS 2; values are declared for what is not a string, or a unit for an unknown name.
            Ros2Error: a topic, service or action of ROS 2 has a wrong name or type.
        """
        topics: dict[str, dict[str, Kind]] = {}
        values: dict[str, tuple[str, ...]] = {}
        for message in self.messages:
            topic = topic_of(message)
            if topic in topics:
                raise ValueError(f"two message classes have the topic {topic!r} on the bus; rename one of them")
            topics[topic] = {}
            for name, kind, texts in comparable_fields(message):
                topics[topic][name] = kind
                if texts:
                    values[f"{topic}.{name}"] = texts
        for part in offers("execution", "EXECUTION"):
            for name, fields in part.topics(self).items():
                if name in topics:
                    raise ValueError(f"{name!r} is both a message of the bus and a topic of ROS 2; rename one of them")
                topics[name] = fields
        return Vocabulary(dict(self.signal_types), topics, {**values, **self.values}, dict(self.units))
