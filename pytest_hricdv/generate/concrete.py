"""Concrete tests: abstract tests with parameters for each action, sampled from declared ranges.

`concretize` makes a `ConcreteTest` of an abstract one, with the ranges of the testbench's `Concretization`; `HriCase`
calls it when its test first runs. Paper: section on concretization; in coverage-driven verification this is constrained
random generation.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace

from msgspec import Struct, to_builtins

from pytest_hricdv._base.input_file import MalformedError, from_json
from pytest_hricdv._base.message import nearest
from pytest_hricdv._base.schedule_record import ScheduleData
from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.abstract import AbstractTest, canonical_command, content_digest, disturbance_of, id_of_test
from pytest_hricdv.generate.actors import (
    PAUSE_S,
    TURN,
    TURN_WAIT_S,
    TURNS,
    After,
    Pause,
    TurnWait,
    act_of,
    actor_of,
    actors_of,
    after_from_data,
    after_of_kept,
    after_to_data,
    stay_of,
)
from pytest_hricdv.generate.chosen_values import RUN, Values, owner
from pytest_hricdv.generate.rng import canonical_json, derive_seed, make_rng
from pytest_hricdv.generate.sampler import SAMPLINGS, Constant, Sampler, Sampling, Uniform
from pytest_hricdv.generate.schedule import ScheduleDecision, schedule_from_data, schedule_to_data

Parameters = Mapping[str, float]
UNIFORM = "uniform"
"""The default of `--hri-sampling`: values are drawn uniformly from their ranges."""

_UNITLESS = Constant(0.0)
"""Formats the values of parameters without a declared range."""


@dataclass(frozen=True)
class Concretization:
    """The ranges from which the parameters of commands are sampled.

    Args:
        commands: for each command line that can be executed, the samplers of its parameters by name (with the unit in
            the name, as in `hold_s`); an empty mapping for a command without parameters.
        run: the samplers of parameters that are drawn once per run.
        turn_wait_s: of a model with several actors: how long an actor who is free waits at most for its turn in the
            interleaving that was drawn (s). It is drawn once per run; with 0 nobody waits, and the order between
            actors comes from the world alone.

    Raises:
        GenerateError: a command that is not in canonical spelling, or a sampler that is no `Sampler`.
    """

    commands: Mapping[str, Mapping[str, Sampler]] = field(hash=False)
    run: Mapping[str, Sampler] = field(default_factory=dict, hash=False)
    turn_wait_s: Uniform | Constant = TurnWait(0.0, 10.0, "s")  # noqa: RUF009  (frozen)

    def __post_init__(self) -> None:
        for command, samplers in self.commands.items():
            if canonical_command(command) != command:
                raise GenerateError(
                    f"concretization of {command!r}: expected the spelling {canonical_command(command)!r}"
                )
            _check_samplers(f"concretization of {command!r}", samplers)
        _check_samplers("concretization of a run", self.run)
        wait = self.turn_wait_s
        if not isinstance(wait, Uniform | Constant) or any(wait_s < 0 for wait_s in wait.corners()):
            raise GenerateError(f"turn_wait_s is {wait!r}; expected a Uniform or Constant of at least 0 s")

    def with_turns(self, actors: Collection[str]) -> Concretization:
        """The space for tests with several actors: each of their commands has a turn, the run a wait for it.

        Raises:
            GenerateError: a command does not name its actor, or has a parameter of that name itself.
        """
        commands = {}
        for command, samplers in self.commands.items():
            actor = actor_of(command)
            if actor not in actors:
                listed = " or ".join(repr(f"{name}: {act_of(command)}") for name in actors)
                raise GenerateError(f"concretization of {command!r}: who does it? Expected {listed}")
            _check_free(f"concretization of {command!r}", TURN, samplers)
            commands[command] = {**samplers, TURN: TURNS}
        _check_free("concretization of a run", TURN_WAIT_S, self.run)
        wait = self.turn_wait_s
        if isinstance(wait, Uniform):
            wait = TurnWait(wait.low, wait.high, wait.unit, wait.open_high)
        return replace(self, commands=commands, run={**self.run, TURN_WAIT_S: wait})

    def with_pauses(self, actors: Collection[str]) -> Concretization:
        """The space for tests that people may have decided during a run: each of their commands has a pause.

        Raises:
            GenerateError: a parameter has such a name already, or the run's wait for a turn has to be above 0.
        """
        commands = dict(self.commands)
        for command, samplers in self.commands.items():
            _check_free(f"concretization of {command!r}", PAUSE_S, samplers)
            commands[command] = {**samplers, PAUSE_S: Pause()}
        stays = {stay_of(actor): Pause() for actor in actors}
        for name in stays:
            _check_free("concretization of a run", name, self.run)
        if not self.run[TURN_WAIT_S].contains(0.0):
            raise GenerateError(
                f"turn_wait_s is {self.turn_wait_s}; expected a range from 0 s on: where people decide during a run, "
                "nobody waits for a turn"
            )
        return replace(self, commands=commands, run={**self.run, **stays})

    def describe(self, test: ConcreteTest) -> tuple[str, ...]:
        """A concrete test for people: one line per action, then one for the run, each value with its unit."""
        lines = [
            _show(action.command, action.parameters, self.commands.get(action.command, {})) for action in test.actions
        ]
        return (*lines, _show("run", test.run, self.run)) if test.run else tuple(lines)


def _show(heading: str, parameters: Parameters, samplers: Mapping[str, Sampler]) -> str:
    values = [f"{name} {samplers.get(name, _UNITLESS).format(value)}" for name, value in parameters.items()]
    return f"{heading}: {', '.join(values)}" if values else heading


def _check_free(where: str, name: str, samplers: Mapping[str, Sampler]) -> None:
    if name in samplers:
        raise GenerateError(f"{where}: {name!r} is the name of a parameter of tests with several actors; rename it")


def _check_samplers(where: str, samplers: Mapping[str, Sampler]) -> None:
    for name, sampler in samplers.items():
        if not isinstance(sampler, Sampler):
            raise GenerateError(
                f"{where}: parameter {name!r} is {sampler!r}; expected a Uniform, Sometimes or Constant"
            )


@dataclass(frozen=True)
class ConcreteAction:
    """One action: its command line and its parameters by name."""

    command: str
    parameters: Parameters = field(default_factory=dict, hash=False)

    @property
    def disturbance(self) -> str | None:
        """The name of the disturbance that happens here; None for what an actor does."""
        return disturbance_of(self.command)


@dataclass(frozen=True)
class ConcreteTest:
    """Everything a run depends on besides the code under test, as data."""

    id: str
    suite: str
    seed: int
    actions: tuple[ConcreteAction, ...]
    run: Parameters = field(default_factory=dict, hash=False)
    after: After = field(default_factory=dict, hash=False)
    """Action -> the actions of other actors that have to be done before it begins, by number from 1."""
    schedule: tuple[ScheduleDecision, ...] = ()
    """The decisions that change the order in which nodes continue; empty for the usual order."""

    def keep(self, places: Iterable[int]) -> ConcreteTest:
        """The same test with only the actions at these places (from 0); their order is kept."""
        kept, lines = sorted(places), [action.command for action in self.actions]
        after = after_of_kept(self.after, [place + 1 for place in kept], lines) if self.after else {}
        return replace(self, actions=tuple(self.actions[place] for place in kept), after=after)

    @property
    def actors(self) -> tuple[str, ...]:
        """The actors in it; empty if its actions name none, for one actor."""
        return actors_of(action.command for action in self.actions)

    def to_json(self) -> str:
        """Canonical JSON; floats are exact."""
        actions = [[action.command, dict(action.parameters)] for action in self.actions]
        plain = {"id": self.id, "suite": self.suite, "seed": self.seed, "actions": actions, "run": dict(self.run)}
        after = {"after": after_to_data(self.after)} if self.after else {}
        schedule = {"schedule": to_builtins(schedule_to_data(self.schedule))} if self.schedule else {}
        return canonical_json({**plain, **after, **schedule})

    @classmethod
    def from_json(cls, text: str) -> ConcreteTest:
        """The test that `to_json` wrote. Raises GenerateError: the text is not such a test."""
        try:
            fields = from_json(text, _TestText)
        except MalformedError as error:
            raise GenerateError(f"not a concrete test{error}; expected what ConcreteTest.to_json writes") from None
        actions = tuple(ConcreteAction(command, parameters) for command, parameters in fields.actions)
        after, schedule = after_from_data(fields.after), schedule_from_data(fields.schedule)
        return cls(fields.id, fields.suite, fields.seed, actions, fields.run, after, schedule)


class _TestText(Struct):
    """The JSON text of a concrete test."""

    id: str
    suite: str
    seed: int
    actions: tuple[tuple[str, dict[str, float]], ...]
    run: dict[str, float]
    after: dict[str, tuple[int, ...]] = {}
    schedule: ScheduleData | None = None


def variant(test: AbstractTest, k: int) -> AbstractTest:
    """The test for the k-th concretization: the same for k = 0, else with an id and a seed derived from it."""
    if k < 0:
        raise GenerateError(f"concretization number {k}: expected at least 0")
    return test if k == 0 else replace(test, id=f"{test.id}-k{k}", seed=derive_seed("variant", test.seed, k))


def expand(tests: Iterable[AbstractTest], concretizations: int, sampling: str = UNIFORM) -> tuple[AbstractTest, ...]:
    """Each test `concretizations` times, its variants next to each other; for k = 0 the id is unchanged.

    Another sampling than the uniform one gives other tests, so these have other ids and seeds.

    Raises:
        GenerateError: fewer than one concretization, or an unknown sampling.
    """
    if sampling not in SAMPLINGS:
        raise GenerateError(f"no sampling {sampling!r}{nearest(sampling, SAMPLINGS)}")
    if sampling != UNIFORM:
        drawn = (replace(test, id=f"{test.id}-{sampling}", seed=derive_seed(sampling, test.seed)) for test in tests)
        return expand(drawn, concretizations)
    if concretizations < 1:
        raise GenerateError(f"{concretizations} concretizations of a test: expected at least 1")
    return tuple(variant(test, k) for test in tests for k in range(concretizations))


def concretize(test: AbstractTest, concretization: Concretization, k: int = 0, sampling: str = UNIFORM) -> ConcreteTest:
    """A test with all its parameters: its chosen values, and sampled ones.

    Each parameter of each action has its own random stream, from the test's seed, the action's place and the
    parameter's name. So its value stays the same when another parameter is added or chosen, or another range is
    changed.

    Raises:
        GenerateError: a command of the test has no declared ranges, or a chosen value is not in a declared range.
    """
    test, sample = variant(test, k), SAMPLINGS[sampling]
    actions = []
    for place, command in enumerate(test.lines):
        chosen, samplers = _choose(test, place + 1, concretization), concretization.commands[command]
        actions.append(ConcreteAction(command, _draw(samplers, chosen, sample, test.seed, place, command)))
    run = _draw(concretization.run, _choose(test, RUN, concretization), sample, test.seed, "run")
    return ConcreteTest(test.id, test.suite, test.seed, tuple(actions), run, test.after)


def draw_action(command: str, concretization: Concretization, seed: int, place: int) -> ConcreteAction:
    """An action of a test that is made up while it runs, with parameters as `concretize` draws them.

    Args:
        place: the place of the action in the test, from 0.

    Raises:
        GenerateError: no ranges are declared for the command.
    """
    samplers = concretization.commands.get(command)
    if samplers is None:
        hint = nearest(command, concretization.commands)
        raise GenerateError(f"command {place + 1}: no ranges are declared for {command!r}{hint}")
    return ConcreteAction(command, _draw(samplers, {}, SAMPLINGS[UNIFORM], seed, place, command))


def _draw(samplers: Mapping[str, Sampler], chosen: Parameters, sample: Sampling, *key: int | str) -> dict[str, float]:
    return {
        name: float(chosen[name]) if name in chosen else sample(sampler, make_rng(*key, name))
        for name, sampler in samplers.items()
    }


def check_values(test: AbstractTest, concretization: Concretization) -> None:
    """Check a test's chosen values. Raises GenerateError as `concretize` does."""
    for number in test.values:
        _choose(test, number, concretization)


def _choose(test: AbstractTest, number: int, concretization: Concretization) -> Parameters:
    """The chosen values of a command, or of the run; each is in its declared range."""
    samplers = concretization.run if number == RUN else _samplers(test, number, concretization)
    chosen = test.values.get(number, {})
    for name, value in chosen.items():
        where = f"test {test.id}, {owner(number)}{'' if number == RUN else f' ({test.lines[number - 1]})'}"
        if name not in samplers:
            declared = ", ".join(sorted(samplers)) or "none"
            raise GenerateError(f"{where}: no parameter {name!r}{nearest(name, samplers)}; declared: {declared}")
        if not samplers[name].contains(value):
            expected = f"expected {samplers[name]}, or no value: then it is drawn"
            raise GenerateError(f"{where}: {name} {value!r} is out of its range; {expected}")
    return chosen


def _samplers(test: AbstractTest, number: int, concretization: Concretization) -> Mapping[str, Sampler]:
    command = test.lines[number - 1]
    if command not in concretization.commands:
        hint = nearest(command, concretization.commands)
        raise GenerateError(f"test {test.id}: no ranges are declared for command {command!r}{hint}")
    return concretization.commands[command]


def values_of(test: ConcreteTest) -> Values:
    """All parameters of a concrete test as chosen values."""
    numbered = {RUN: test.run} | {number: action.parameters for number, action in enumerate(test.actions, 1)}
    return {number: dict(parameters) for number, parameters in numbered.items() if parameters}


def abstract_from(test: ConcreteTest, target: str, *, name: str = "", keeps_id: bool = False) -> AbstractTest:
    """The abstract test that concretizes to this concrete one, so that a run whose actions were produced online, or
    changed by a search, can be stored and run again as any other test.

    All its parameters are chosen values. It comes from no beliefs.

    Args:
        test: the test, with the actions that were taken.
        target: what the test is to exercise, in a few words.
        name: a title for people; may be empty.
        keeps_id: whether it has the id of the concrete test; otherwise one from target and content, as a draft has.
    """
    lines, values = tuple(action.command for action in test.actions), values_of(test)
    code = content_digest(test.suite, (), lines, test.seed, 0, values, test.after)
    test_id = test.id if keeps_id else id_of_test(test.suite, target, code[:8])
    return AbstractTest(
        test_id, test.suite, target, (), lines, seed=test.seed, name=name, values=values, after=test.after
    )
