"""Neighbours of a concrete test: the same actions with other parameters, each within its declared range."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from random import Random

from pytest_hricdv.generate.concrete import ConcreteTest, Concretization, Parameters
from pytest_hricdv.generate.sampler import Chance, Range, Sampler
from pytest_hricdv.generate.stream import index, pick

from .simpler import landmarks

_FRESH, _CORNER = 0.1, 0.1  # of changes; the rest are steps nearby


def mutated(test: ConcreteTest, space: Concretization, step: float, random: Random) -> ConcreteTest:
    """A neighbour: one parameter is changed in any case, and each other one with a chance of one in their number.

    A change is a step nearby, of at most `step` of the range's width; now and then a value drawn afresh, or one of the
    range's landmarks (see `simpler`). Parameters that cannot be otherwise are left alone; without any other, the test
    is returned as it is.

    Args:
        test: where to start.
        space: the ranges.
        step: share of a range's width, from 0 to 1.
        random: a private stream.
    """
    actions = [(action.parameters, space.commands.get(action.command, {})) for action in test.actions]
    spots = [
        (place, name)
        for place, (parameters, samplers) in enumerate([(test.run, space.run), *actions])
        for name in sorted(parameters)
        if name in samplers and len(set(landmarks(samplers[name]))) > 1
    ]
    if not spots:
        return test
    certain = spots[index(random, len(spots))]
    chosen = {spot for spot in spots if random.random() * len(spots) < 1.0} | {certain}

    def changed(place: int, parameters: Parameters, samplers: Mapping[str, Sampler]) -> Parameters:
        values = dict(parameters)
        for name in sorted(name for spot, name in chosen if spot == place):
            values[name] = _other(values[name], samplers[name], step, random)
        return values

    run = changed(0, test.run, space.run)
    others = (
        replace(action, parameters=changed(place, action.parameters, space.commands.get(action.command, {})))
        for place, action in enumerate(test.actions, 1)
    )
    return replace(test, actions=tuple(others), run=run)


def _other(value: float, sampler: Sampler, step: float, random: Random) -> float:
    share = random.random()
    if share < _FRESH:
        return sampler.sample(random)
    if share < _FRESH + _CORNER:
        return pick(random, landmarks(sampler))
    inside = sampler.then if isinstance(sampler, Chance) else sampler
    if not isinstance(inside, Range):
        return pick(random, landmarks(sampler))
    # What has not happened steps to where it has.
    start = value if inside.contains(value) else inside.sample(random)
    return inside.clipped(start + (2.0 * random.random() - 1.0) * step * (inside.high - inside.low))
