"""`check_testbench`, for `Collection`: checks a testbench's types, names and ranges, and raises the first error."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, get_args, get_origin, get_type_hints

from pytest_hricdv._base.message import nearest
from pytest_hricdv.coverage.cross_product import CrossProduct
from pytest_hricdv.declarations.bystander import Bystander
from pytest_hricdv.declarations.model_oracle import ModelOracle
from pytest_hricdv.declarations.ros2 import Ros2, Ros2Error
from pytest_hricdv.disturbance import faults
from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.beliefs import BeliefSpace
from pytest_hricdv.generate.concrete import Concretization
from pytest_hricdv.generate.model import Model
from pytest_hricdv.generate.qlearning import QLearning
from pytest_hricdv.monitor import Requirement
from pytest_hricdv.online.declaration import InteractiveAgent
from pytest_hricdv.registry import FEATURES, offers
from pytest_hricdv.run import TestbenchError
from pytest_hricdv.runtime import fields_of, topic_of
from pytest_hricdv.runtime.message_fields import FORMS
from pytest_hricdv.runtime.virtual.reach import TOOLS
from pytest_hricdv.testbench import FIELD_PURPOSES, Testbench
from pytest_hricdv.testbench_groups import Field, People, Signal, Simulation, StateField, Suites, VirtualTime

NEEDED_PARTS = {"oracle": "oracle", "ros2": "ros2"}
"""Declaration of a testbench -> the optional feature without which it would be silently ignored."""

MOVED_KEYWORDS: Mapping[str, Mapping[str, str]] = {
    "Testbench": {
        "virtual": "time=VirtualTime(apis=...)",
        "patience_s": "time=VirtualTime(stall_timeout_s=...)",
        "may_end": "time=VirtualTime(allowed_endings=...)",
        "online": "people=People(agents=(InteractiveAgent(...),))",
        "bystanders": "people=People(bystanders=...)",
        "units": "signals={NAME: Signal(TYPE, unit=...)}, or fields={'TOPIC.FIELD': Field(unit=...)}",
        "values": "signals={NAME: Signal(str, values=...)}, or fields={'TOPIC.FIELD': Field(values=...)}",
        "sampled_while": "signals={NAME: Signal(TYPE, sampled_while=...)}",
        "by_hand": "suites=Suites(by_hand=...)",
        "learning": "suites=Suites(learning=...)",
        "lengths": "suites=Suites(random_test_length=...)",
        "transitions": "state=StateField(..., transitions=...)",
        "conformance": "oracle=ModelOracle(...)",
        "fidelities": "simulation=Simulation(fidelities=...)",
        "engines": "simulation=Simulation(engines=...)",
        "engine_tolerances": "simulation=Simulation(engine_tolerances=...)",
        "requires": "simulation=Simulation(requires=...)",
        "film": "simulation=Simulation(film=...)",
    },
    "InteractiveAgent": {"hears": "percepts=...", "patience_s": "idle_timeout_s=..."},
    "ModelOracle": {"hears": "percepts=...", "does": "actions=..."},
    "Ros2": {"patience_s": "idle_timeout_s=..."},
}
"""A class -> its former keywords -> what replaces each."""


def check_testbench(candidate: object, where: str) -> Testbench:
    """`candidate` as a testbench.

    Raises:
        TestbenchError: it is none, or a part is of the wrong kind; `where` is named.
    """
    if not isinstance(candidate, Testbench):
        raise TestbenchError(
            f"{where}: returned {candidate!r:.80}; expected a Testbench (from pytest_hricdv.testbench import Testbench)"
        )
    _check_kinds(candidate, where)
    for name, part in NEEDED_PARTS.items():
        if getattr(candidate, name) is not None and part not in FEATURES:
            raise TestbenchError(f"{where}: {name}=... needs the part {part!r} of the plugin, which was taken out")
    try:
        for part in offers("execution", "EXECUTION"):
            part.prepare(candidate)  # before the vocabulary: that imports the classes of messages, and with them rclpy
        topics = candidate.vocabulary().messages
        disturbance_faults = faults(candidate.disturbances, candidate.concretization.commands, topics)
        for fault in (
            *_code_faults(candidate),
            *_film_faults(candidate),
            *_state_faults(candidate),
            *candidate.time.faults(),
            *candidate.timing.faults(),
            *_sampling_faults(candidate),
            *_bystander_faults(candidate),
            *_agent_faults(candidate),
            *disturbance_faults,
            *_type_faults(candidate),
        ):
            raise TestbenchError(f"{where}: {fault}")
        _ = candidate.commands
    except (ValueError, GenerateError, Ros2Error) as error:
        raise TestbenchError(f"{where}: {error}") from None
    return candidate


def describe_keywords(error: BaseException) -> str:
    """The lines of the error of a declaration: the purpose of each missing keyword, the successor of each moved one."""
    if not isinstance(error, TypeError):
        return ""
    class_name, is_init, fault = str(error).partition(".__init__() ")
    if not is_init:
        return ""
    if class_name == Testbench.__name__ and "missing" in fault:
        return "".join(f"\n  {name}: {purpose}" for name, purpose in FIELD_PURPOSES.items() if f"'{name}'" in fault)
    moved = MOVED_KEYWORDS.get(class_name, {}) if "unexpected keyword" in fault else {}
    return "".join(f"\n  {name}=... is now {now}" for name, now in moved.items() if f"'{name}'" in fault)


def _code_faults(testbench: Testbench) -> Iterator[str]:
    """Packages that cannot be code under test, as they run the tests."""
    for package in testbench.code:
        if package.partition(".")[0] in TOOLS:
            yield f"code names {package!r}, which itself runs the tests; expected packages of the code under test"


def _check_kinds(testbench: Testbench, where: str) -> None:
    expected: Mapping[str, type[Any]] = {"model": Model, "beliefs": BeliefSpace, "concretization": Concretization}
    for name, kind in expected.items():
        if not isinstance(getattr(testbench, name), kind):
            raise TestbenchError(f"{where}: {name} is {getattr(testbench, name)!r}; expected {FIELD_PURPOSES[name]}")
    groups: Mapping[str, type[Any]] = {
        "time": VirtualTime,
        "simulation": Simulation,
        "people": People,
        "suites": Suites,
        "state": StateField,
    }
    for name, kind in groups.items():
        if not isinstance(getattr(testbench, name), kind):
            raise TestbenchError(f"{where}: {name} is {getattr(testbench, name)!r}; expected {kind.__name__}(...)")
    if not isinstance(testbench.suites.learning, QLearning):
        raise TestbenchError(
            f"{where}: suites: learning is {testbench.suites.learning!r}; expected constants of learning (QLearning)"
        )
    if not isinstance(testbench.signals, Mapping):
        raise TestbenchError(f"{where}: signals is {testbench.signals!r}; expected {FIELD_PURPOSES['signals']}")
    fields = testbench.fields
    if not isinstance(fields, Mapping) or not all(isinstance(declared, Field) for declared in fields.values()):
        raise TestbenchError(f"{where}: fields is {fields!r}; expected a mapping of topic.field to Field(...)")
    if not isinstance(testbench.cross, Mapping):
        raise TestbenchError(f"{where}: cross is {testbench.cross!r}; expected {FIELD_PURPOSES['cross']}")
    for name, product in testbench.cross.items():
        if not isinstance(product, CrossProduct):
            raise TestbenchError(f"{where}: cross product {name!r} is {product!r}; expected a CrossProduct")
    optional: Mapping[str, type[Any]] = {"oracle": ModelOracle, "ros2": Ros2}
    for name, kind in optional.items():
        part = getattr(testbench, name)
        if not isinstance(part, kind | None):
            raise TestbenchError(f"{where}: {name} is {part!r}; expected {kind.__name__}(...) or None")
    if not callable(testbench.run):
        raise TestbenchError(f"{where}: run is {testbench.run!r}; expected {FIELD_PURPOSES['run']}")
    if isinstance(testbench.code, str) or not testbench.code:
        raise TestbenchError(f"{where}: code is {testbench.code!r}; expected a tuple of {FIELD_PURPOSES['code']}")
    for message in testbench.messages:
        if fields_of(message) is None:
            raise TestbenchError(f"{where}: message {message!r} is not a class with fields; expected {FORMS}")
    paths = {"suites: by_hand": testbench.suites.by_hand}
    if isinstance(testbench.requirements, tuple):
        for requirement in testbench.requirements:
            if not isinstance(requirement, Requirement):
                raise TestbenchError(
                    f"{where}: requirement {requirement!r} is none; expected {FIELD_PURPOSES['requirements']}"
                )
    else:
        paths["requirements"] = testbench.requirements
    for name, path in paths.items():
        if path is not None and not Path(path).is_file():
            raise TestbenchError(f"{where}: {name} is {path}, and there is no such file")


def _film_faults(testbench: Testbench) -> list[str]:
    topics = {topic_of(kind): frozenset(fields_of(kind) or ()) for kind in testbench.messages}
    film = testbench.simulation.film
    return film.faults(testbench.vocabulary(), topics) if film is not None else []


def _state_faults(testbench: Testbench) -> Iterator[str]:
    topic, _, name = testbench.state.name.partition(".")
    topics = testbench.vocabulary().messages
    if testbench.state.name and topics.get(topic, {}).get(name) is not str:
        texts = sorted(
            f"{message}.{field}" for message, kinds in topics.items() for field in kinds if kinds[field] is str
        )
        listed = ", ".join(texts) or "none"
        yield f"state: name is {testbench.state.name!r}, which is not a string field of a message; there are: {listed}"
    if testbench.state.transitions and not testbench.state.name:
        yield "state: transitions are given, but no name: expected a string field, such as StateField('state.name')"
    states = testbench.values.get(testbench.state.name, ())
    for pair in testbench.state.transitions:
        if not (isinstance(pair, tuple) and len(pair) == 2 and all(isinstance(name, str) for name in pair)):
            yield f"state: transitions has {pair!r}; expected pairs of states, such as ('Idle', 'Move_hand')"
            continue
        for name in pair if states else ():
            if name not in states:
                no_value = f"{name!r} is not a value of {testbench.state.name}{nearest(name, states)}"
                yield f"state: transitions has {pair!r}: {no_value}"


def _agent_faults(testbench: Testbench) -> Iterator[str]:
    agents = testbench.people.agents
    if not isinstance(agents, tuple) or not all(isinstance(agent, InteractiveAgent) for agent in agents):
        yield f"people: agents is {agents!r}; expected a tuple of InteractiveAgent(...), one for each actor"
        return
    if not agents:
        return
    names, actors = [agent.agent for agent in agents], testbench.model.actors
    if not actors:
        if len(names) > 1:
            yield (
                f"people: agents has {', '.join(names)}, and the model the actor {testbench.model.actor}; expected "
                "one, or Model(actors=(...)) with all of them"
            )
        return
    for place, name in enumerate(names):
        if name not in actors:
            yield f"people: agents has {name!r}, which is not an actor of the model{nearest(name, actors)}"
        if name in names[:place]:
            yield f"people: agents has {name!r} twice; expected one InteractiveAgent(...) for each actor"
    missing = [actor for actor in actors if actor not in names]
    if missing:
        listed = ", ".join(f"InteractiveAgent({actor!r})" for actor in missing)
        yield f"people: agents does not have all actors of the model, who decide during a run together; add {listed}"


def _bystander_faults(testbench: Testbench) -> Iterator[str]:
    if not isinstance(testbench.people.bystanders, tuple):
        yield f"people: bystanders is {testbench.people.bystanders!r}; expected a tuple of Bystander(...)"
        return
    names = [*testbench.model.who_acts]
    parameters = {*testbench.concretization.run}
    for bystander in testbench.people.bystanders:
        if not isinstance(bystander, Bystander):
            yield f"people: bystanders has {bystander!r}; expected a Bystander(...)"
            continue
        if bystander.name in names:
            yield f"bystander {bystander.name!r}: another actor has this name; rename one of them"
        for name in sorted(parameters.intersection(bystander.parameters)):
            yield f"bystander {bystander.name!r}: the run has a parameter {name!r} already; rename one of them"
        names.append(bystander.name)
        parameters.update(bystander.parameters)


def _sampling_faults(testbench: Testbench) -> Iterator[str]:
    switches = [name for name, kind in testbench.signal_types.items() if kind is bool]
    for name, switch in testbench.sampling_conditions.items():
        if switch not in switches:
            listed = ", ".join(switches) or "none"
            yield f"signals[{name!r}]: sampled_while is {switch!r}, which is not a bool signal; there are: {listed}"


def _type_faults(testbench: Testbench) -> Iterator[str]:
    """Strings and tuples that are something else. In place of a tuple, a string would be taken for its letters."""
    parts = {name: getattr(testbench, name) for name in ("time", "simulation", "suites", "state")}
    parts |= {f"signals[{name!r}]": signal for name, signal in testbench.signals.items() if isinstance(signal, Signal)}
    parts |= {f"fields[{name!r}]": field for name, field in testbench.fields.items()}
    for command, ranges in {**testbench.concretization.commands, "run": testbench.concretization.run}.items():
        parts |= {f"{command}: {name}": sampler for name, sampler in ranges.items()}
    for owner, part in parts.items():
        for name, hint in get_type_hints(type(part)).items():
            if not _fits(getattr(part, name), hint):
                expected = "a string" if hint is str else hint
                yield f"{owner}: {name} is {getattr(part, name)!r}; expected {expected}"


def _fits(value: object, hint: object) -> bool:
    """Whether a value is of an annotated type, as far as that is made of strings, integers and tuples."""
    if get_origin(hint) is not tuple:
        return not isinstance(hint, type) or hint not in (str, int) or isinstance(value, hint)
    if not isinstance(value, tuple):
        return False
    kinds = get_args(hint)
    kinds = kinds[:1] * len(value) if kinds[-1] is ... else kinds
    return len(kinds) == len(value) and all(map(_fits, value, kinds))
