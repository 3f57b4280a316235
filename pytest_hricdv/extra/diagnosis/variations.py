"""Variations of a failing test, each with one change and its description.

`NeighborSearch` runs them in the order of `variations`: what says most about a cause in few runs comes first. Leaving a
disturbance out names what must not happen; another order of two actors names a race; another command of the same kind
(`set_param pressure = 1` instead of `= 0`) leaves the rest of the test as it was. Values come last: there are most of
them, and each may have a threshold. Actions that begin last before the violation are varied first.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from pytest_hricdv.extra.diagnosis.runs import RunSummary
from pytest_hricdv.generate.actors import TURN, TURN_WAIT_S, actor_of, interleave
from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest, Concretization, Parameters, draw_action
from pytest_hricdv.generate.sampler import Sampler

Spot = tuple[int | None, str]
"""The place of a parameter: the number (from 0) of its action, or None for a parameter of the run; and its name."""

SAME_TIME_S = 1e-3
"""Difference (s) up to which two actions begin at the same time: the resolution of times in a report."""


@dataclass(frozen=True)
class Variation:
    """A test that differs from another one in one thing.

    Args:
        kind: what differs.
        words: the difference, in words that follow "passes".
        test: the test with the difference.
        spot: the parameter, if a value differs; `value` is the other value.
    """

    kind: Literal["schedule", "disturbance", "order", "value", "command", "action"]
    words: str
    test: ConcreteTest
    spot: Spot = (None, "")
    value: float = 0.0


def variations(test: ConcreteTest, space: Concretization, begun: Sequence[int] | None = None) -> Iterator[Variation]:
    """All variations of a failing test, in the order in which they are to be tried.

    Args:
        space: the ranges of its parameters.
        begun: numbers (from 0) of the actions begun by the violation: later ones cannot decide. The last of them
            come first. None for all.
    """
    yield from _other_schedules(test)
    last_first = [*range(len(test.actions))][::-1] if begun is None else [*reversed(begun)]
    yield from _without_disturbances(test, last_first)
    yield from _swap(test)
    yield from _other_commands(test, space, last_first)
    yield from _without_actions(test, last_first)
    yield from values(test, space, last_first)


def values(test: ConcreteTest, space: Concretization, places: Sequence[int]) -> Iterator[Variation]:
    """Variations with another value of a parameter: the first one of each parameter, then the second ones.

    Args:
        test: the test that fails.
        space: the ranges of its parameters.
        places: the places of the actions whose parameters are varied, in this order.
    """
    spots = {spot: _other_values(test, space, spot) for spot in _spots(test, places)}
    for number in range(2):
        yield from (
            with_value(test, space, spot, others[number]) for spot, others in spots.items() if number < len(others)
        )


def without(test: ConcreteTest, name: str) -> ConcreteTest:
    """The test without a disturbance, wherever it comes."""
    return test.keep(place for place, action in enumerate(test.actions) if action.disturbance != name)


def _other_schedules(test: ConcreteTest) -> Iterator[Variation]:
    """Under the usual order of the code's threads."""
    if test.schedule:
        first, *others = test.schedule
        words = "under the usual schedule"
        if first.place and not others:
            words = f"without the {'delay of' if first.kind == 'delivery' else 'wait before'} {first.place}"
        yield Variation("schedule", words, replace(test, schedule=()))


def _without_disturbances(test: ConcreteTest, places: Sequence[int]) -> Iterator[Variation]:
    names = (test.actions[place].disturbance for place in places)
    for name in dict.fromkeys(name for name in names if name is not None):
        yield Variation("disturbance", f"without the disturbance {name}", without(test, name))


def _swap(test: ConcreteTest) -> Iterator[Variation]:
    """Neighbours in the order of all actors, the other way round, where neither has to wait for the other.

    If nobody waits for a turn, the world decides the order: keys of turns would change nothing.
    """
    if not test.run.get(TURN_WAIT_S):
        return
    lines = [action.command for action in test.actions]
    turns = [action.parameters.get(TURN, 0.0) for action in test.actions]
    order = interleave(lines, turns, test.after)
    for place in range(len(order) - 1):
        first, second = order[place], order[place + 1]
        swapped = (*order[:place], second, first, *order[place + 2 :])
        keys = {number: rank / len(order) for rank, number in enumerate(swapped)}
        changed = [keys.get(number, turn) for number, turn in enumerate(turns, 1)]
        if interleave(lines, changed, test.after) != swapped:  # one actor's order, or a cause before its effect
            continue
        actions = (
            replace(action, parameters={**action.parameters, TURN: key}) if TURN in action.parameters else action
            for action, key in zip(test.actions, changed, strict=True)
        )
        words = f"when {lines[second - 1]} comes before {lines[first - 1]}"
        yield Variation("order", words, replace(test, actions=tuple(actions)))


def _spots(test: ConcreteTest, places: Sequence[int]) -> tuple[Spot, ...]:
    """The parameters: first of disturbances, then of the run, then of other actions.

    Turns are not among them: `_swap` has all orders of neighbours.
    """
    disturbing = [place for place in places if test.actions[place].disturbance is not None]
    listed: list[Spot] = [(place, name) for place in disturbing for name in sorted(test.actions[place].parameters)]
    listed += [(None, name) for name in sorted(test.run)]
    others = (place for place in places if place not in disturbing)
    listed += [(place, name) for place in others for name in sorted(test.actions[place].parameters)]
    return tuple(spot for spot in listed if spot[1] not in (TURN, TURN_WAIT_S))


def value_of(test: ConcreteTest, spot: Spot) -> float:
    """The value of a parameter."""
    place, name = spot
    return (test.run if place is None else test.actions[place].parameters)[name]


def sampler_of(test: ConcreteTest, space: Concretization, spot: Spot) -> Sampler | None:
    """The range of a parameter; None if none is declared."""
    place, name = spot
    samplers: Mapping[str, Sampler] = (
        space.run if place is None else space.commands.get(test.actions[place].command, {})
    )
    return samplers.get(name)


def _other_values(test: ConcreteTest, space: Concretization, spot: Spot) -> tuple[float, ...]:
    """The ends of its range, the farther one first: between them lies whatever threshold there is."""
    sampler, value = sampler_of(test, space, spot), value_of(test, spot)
    if sampler is None:
        return ()
    ends = dict.fromkeys((*sampler.corners(), *sampler.simple_values()))
    return tuple(sorted((end for end in ends if end != value), key=lambda end: (-abs(end - value), end)))[:2]


def with_value(test: ConcreteTest, space: Concretization, spot: Spot, value: float) -> Variation:
    """The test with another value of a parameter."""
    place, name = spot
    sampler = sampler_of(test, space, spot)
    shown = sampler.format if sampler is not None else str
    owner = "the run" if place is None else test.actions[place].command
    words = f"with {name} of {owner} {shown(value)} instead of {shown(value_of(test, spot))}"
    if place is None:
        return Variation("value", words, replace(test, run={**test.run, name: value}), spot, value)
    action = test.actions[place]
    changed = _with_action(test, place, replace(action, parameters={**action.parameters, name: value}))
    return Variation("value", words, changed, spot, value)


def _other_commands(test: ConcreteTest, space: Concretization, places: Sequence[int]) -> Iterator[Variation]:
    """Commands that differ in their last word only, as `set_param gaze = 1` and `set_param gaze = 0` do."""
    for place, action in ((place, test.actions[place]) for place in places):
        head, _, last = action.command.rpartition(" ")
        if not head or action.disturbance is not None or (actor_of(action.command) and head.endswith(":")):
            continue
        for command in sorted(space.commands):
            if command.rpartition(" ")[0] == head and command.rpartition(" ")[2] != last:
                drawn = draw_action(command, space, test.seed, place)
                kept: Parameters = {
                    name: action.parameters.get(name, value) for name, value in drawn.parameters.items()
                }
                words = f"with {command} instead of {action.command}"
                yield Variation("command", words, _with_action(test, place, ConcreteAction(command, kept)))


def _without_actions(test: ConcreteTest, places: Sequence[int]) -> Iterator[Variation]:
    for place, action in ((place, test.actions[place]) for place in places):
        if action.disturbance is None:
            kept = (other for other in range(len(test.actions)) if other != place)
            words = f"without the action {place + 1}, {action.command}"
            yield Variation("action", words, test.keep(kept))


def _with_action(test: ConcreteTest, place: int, action: ConcreteAction) -> ConcreteTest:
    return replace(test, actions=(*test.actions[:place], action, *test.actions[place + 1 :]))


def delay(test: ConcreteTest, failing: RunSummary, passing: RunSummary) -> str:
    """`when disturb step_in comes 2.1 s later`; empty if no action begins at another time, or others do.

    Args:
        test: the test, with the actions of both runs.
        failing: its run.
        passing: the run of the other one, whose actions are the same.
    """
    begins = [{number: time_s for time_s, number in run.begun} for run in (failing, passing)]
    for number in sorted(begins[0].keys() & begins[1].keys(), key=lambda number: begins[0][number]):
        later_s = begins[1][number] - begins[0][number]
        if abs(later_s) > SAME_TIME_S:
            word = "later" if later_s > 0 else "earlier"
            return f"when {test.actions[number].command} comes {abs(later_s):.3g} s {word}"
    return ""
