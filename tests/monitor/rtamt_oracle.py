"""rtamt's offline evaluation in discrete time, for the common part of both languages.

D. Nickovic and T. Yamaguchi, "RTAMT: Online Robustness Monitors from STL", ATVA 2020; https://github.com/nickovic/rtamt

A run is sampled once per tick. Signals change only at ticks, so a formula over signals keeps its value until the next
tick; messages and edges are true only at the tick. What rtamt does not have is expressed by what it has: hysteresis by
`since`, a minimum duration by `historically`, a trigger by a tick at which an antecedent becomes true.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import rtamt  # type: ignore[import-untyped]

from pytest_hricdv.monitor.analysis import names_of, topics_of
from pytest_hricdv.monitor.formula import AlwaysWithin, Eventually, Formula, Holds, Response
from pytest_hricdv.monitor.node import PastFormula, Term
from pytest_hricdv.monitor.past_formula import (
    BooleanName,
    Conjunction,
    Disjunction,
    Fall,
    Historically,
    Negation,
    NumberComparison,
    On,
    Once,
    Previously,
    Rise,
    Since,
)
from pytest_hricdv.monitor.terms import ArithmeticTerm, FloatName, Negative, NumberTerm
from tests.monitor.logged_run import TICK_S, Instant, LoggedRun

Samples = dict[str, list[float]]


@dataclass(frozen=True)
class Counts:
    """The part of a verdict that rtamt can give."""

    verdict: str
    triggers: int
    passes: int
    failures: int
    pending: int


def judge(formula: Formula, trace: LoggedRun) -> Counts:
    """The counts of a run by rtamt."""
    kinds = names_of(formula.conditions)
    topics = topics_of(formula.conditions)
    samples = sampled(trace, list(kinds), sorted(topics))
    antecedent = evaluated(past(formula.antecedent), samples)
    response = evaluated(responded(formula.response), samples)
    if isinstance(formula.response, Holds):
        return _episodes(antecedent, response, lasting=not formula.antecedent.is_instantaneous)
    lasting = not formula.antecedent.is_instantaneous
    triggers = [t for t, holds in enumerate(antecedent) if holds and not (lasting and t > 0 and antecedent[t - 1])]
    undecided = [t for t in triggers if _is_undecided(formula.response, t, response[t], trace.last)]
    failures = sum(not response[t] for t in triggers if t not in undecided)
    return _counts(len(triggers), failures, len(undecided))


def _episodes(antecedent: list[bool], response: list[bool], *, lasting: bool) -> Counts:
    episode, failed = 0, set()
    for t, holds in enumerate(antecedent):
        if holds:
            episode += not (lasting and t > 0 and antecedent[t - 1])
            if not response[t]:
                failed.add(episode)
    return _counts(episode, len(failed), 0)


def _is_undecided(response: Response, trigger: int, holds: bool, last: int) -> bool:
    match response:
        case Eventually():
            return not holds and trigger + _ticks(response.end_s) > last
        case AlwaysWithin():
            return trigger + _ticks(response.start_s) > last
        case _:
            return False


def _counts(triggers: int, failures: int, pending: int) -> Counts:
    passes = triggers - failures - pending
    return Counts("Failed" if failures else "Passed" if passes else "NC", triggers, passes, failures, pending)


# --- a run as samples


def sampled(trace: LoggedRun, names: list[str], topics: list[str]) -> Samples:
    """One value per tick: signals and fields keep theirs, a topic is 1 at the tick of a message, else -1."""
    samples: Samples = {variable: [] for variable in (*map(_variable, (*names, *topics)), "tick")}
    values: dict[str, float] = {}
    for tick in range(trace.last + 1):
        instant = trace.instants.get(tick, Instant())
        values.update({name: _number(value) for name, value in instant.signals.items() if name in names})
        for topic, fields in instant.messages:
            of_topic = {f"{topic}.{name}": value for name, value in fields.items()}
            values.update({name: _number(value) for name, value in of_topic.items() if name in names})
        arrived = {topic for topic, _ in instant.messages}
        for name in names:
            samples[_variable(name)].append(values.get(name, -1.0))
        for topic in topics:
            samples[_variable(topic)].append(1.0 if topic in arrived else -1.0)
        samples["tick"].append(float(tick))
    return samples


def _number(value: float | bool | str) -> float:
    assert not isinstance(value, str)
    return (1.0 if value else -1.0) if isinstance(value, bool) else value


def _variable(name: str) -> str:
    return "v_" + name.replace(".", "__")


def evaluated(specification: str, samples: Samples) -> list[bool]:
    """The truth of a specification at each tick. No value here lies on a bound, where robustness says nothing."""
    times = list(range(len(samples["tick"])))
    result = _parsed(specification, tuple(samples)).evaluate({"time": times, **samples})
    assert all(value != 0 for _, value in result), "a value on a bound"
    return [value > 0 for _, value in result]


@lru_cache(maxsize=64)
def _parsed(specification: str, variables: tuple[str, ...]) -> rtamt.StlDiscreteTimeSpecification:
    parsed = rtamt.StlDiscreteTimeSpecification()
    for name in variables:
        parsed.declare_var(name, "float")
    parsed.spec = specification
    parsed.parse()
    return parsed


# --- formulas in rtamt's language


def responded(response: Response) -> str:
    """A response as seen from its trigger."""
    condition = past(response.condition, remembers=isinstance(response, Eventually))
    match response:
        case Holds():
            return condition
        case Eventually():
            return f"eventually{_window(response.start_s, response.end_s)}({condition})"
        case AlwaysWithin():
            return f"always{_window(response.start_s, response.end_s)}({condition})"
        case _:
            # Weak until; at the release, the condition may be false.
            release = past(response.release)
            return f"(always({condition})) or (({condition} or {release}) until ({release}))"


def past(formula: PastFormula, *, remembers: bool = True) -> str:
    """A past formula; unless it `remembers`, a hysteresis does nothing, as where the first violation decides.

    Inside past operators, and so in a comparison with `[for d]`, it is over the run in any case.
    """
    match formula:
        case BooleanName():
            return f"({_variable(formula.name)} > 0)"
        case On():
            return f"({_variable(formula.topic)} > 0)"
        case NumberComparison():
            return _comparison(formula, remembers)
        case Negation():
            return f"(not {past(formula.operand, remembers=remembers)})"
        case Conjunction():
            return f"({' and '.join(past(part, remembers=remembers) for part in formula.operands)})"
        case Disjunction():
            return f"({' or '.join(past(part, remembers=remembers) for part in formula.operands)})"
        case Rise() | Fall():
            # For rtamt, what is true at the first tick is an edge.
            return f"({type(formula).__name__.lower()}({past(formula.operand)}) and (tick > 0.5))"
        case Previously():
            return f"(prev({past(formula.operand)}))"
        case Once() | Historically():
            return _windowed(formula)
        case Since():
            return f"({past(formula.left)} since {past(formula.right)})"
        case _:
            raise AssertionError(formula)


def _windowed(formula: Once | Historically) -> str:
    operator, operand = type(formula).__name__.lower(), past(formula.operand)
    if math.isinf(formula.end_s):
        unbounded = f"{operator}({operand})"
        return f"({operator}{_window(formula.start_s, formula.start_s)}({unbounded}))"
    return f"({operator}{_window(formula.start_s, formula.end_s)}({operand}))"


def _comparison(formula: NumberComparison, remembers: bool) -> str:
    left, right = _term(formula.left), _term(formula.right)
    bare = f"({left} {formula.relation} {right})"
    if formula.hysteresis and (remembers or formula.for_s):
        sign = "-" if formula.relation in ("<", "<=") else "+"
        returned = f"({left} {formula.relation} {right} {sign} {formula.hysteresis})"
        bare = f"(({bare} since {returned}) or historically({bare}))"
    if formula.for_s:
        ticks = _ticks(formula.for_s)
        return f"(historically[0:{ticks}]({bare}) and (tick > {ticks - 0.5}))"
    return bare


def _term(term: Term) -> str:
    match term:
        case NumberTerm():
            return repr(term.value)
        case FloatName():
            return _variable(term.name)
        case ArithmeticTerm():
            return f"({_term(term.left)} {term.operator} {_term(term.right)})"
        case Negative():
            return f"(0 - {_term(term.operand)})"
        case _:
            raise AssertionError(term)


def _window(start_s: float, end_s: float) -> str:
    return f"[{_ticks(start_s)}:{_ticks(end_s)}]"


def _ticks(time_s: float) -> int:
    return round(time_s / TICK_S)
