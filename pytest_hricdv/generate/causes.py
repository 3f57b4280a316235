"""`causes` finds the causal order between actions of different actors in a run of the model.

`ModelRunner` and `online.enacted_lanes` call it; tests keep this order, whichever way the lanes interleave.

An action comes after one of another actor if it depends on it (L. Lamport: Time, Clocks, and the Ordering of Events in
a Distributed System, CACM 21(7), 1978, with plans in place of processes):

- A step depends on what caused it: an action on the choice of its plan, this on its event, an event on the message that
  led to it, also from agent to agent.
- The steps that follow from one event, with its subgoals, are one *line* of an agent. A step depends on the earlier
  steps of its line, so a message depends on the actions before it in its line.
- A plan and its steps depend on earlier changes of beliefs that the plan names in its trigger, context or body, or
  by a rule.
- After a line has asked another agent something, it depends on the messages of that agent, which may be the answer.

The environment of a model's run changes nothing, so all percepts are there from the start, and cause no order.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Collection, Mapping

from pytest_hricdv.bdi import Structure
from pytest_hricdv.bdi.language.syntax import Program
from pytest_hricdv.bdi.language.syntax_tree import functors_of
from pytest_hricdv.bdi.run.tracing import Step, Trace, place_of_plan

Past = frozenset[int]
"""The numbers of the actions, from 1, that a step depends on."""

_NOTHING: Past = frozenset()


def causes(trace: Trace, programs: Mapping[str, Program], actors: Collection[str]) -> dict[int, tuple[int, ...]]:
    """The actions of other actors that each action depends on, by number from 1; implied ones are left out.

    Args:
        actors: those whose external actions are the test.
    """
    finder = _CauseFinder(programs, actors)
    for step in trace:
        finder.take(step)
    return finder.direct()


class _CauseFinder:
    def __init__(self, programs: Mapping[str, Program], actors: Collection[str]) -> None:
        self._names = {agent: _names_of_plans(program) for agent, program in programs.items()}
        self._actors = actors
        self._steps: dict[int, Step] = {}
        self._past: dict[int, Past] = {}
        self._line_of: dict[int, int] = {}
        """Step -> the first step of its line."""
        self._line_past: dict[int, Past] = defaultdict(lambda: _NOTHING)
        self._plans_of_line: dict[int, list[int]] = defaultdict(list)
        """Line -> the steps that chose its plans, those of ended subgoals left out as soon as that shows."""
        self._believed: dict[str, dict[str, Past]] = defaultdict(dict)
        """Agent -> functor of what it has come to believe, or does not believe any more -> what that depends on."""
        self._asking: dict[tuple[str, str], list[int]] = defaultdict(list)
        """Asked and asking agent -> the lines that asked."""
        self._plan_names: dict[int, Collection[str] | None] = {}
        """Step that chose a plan -> the names in the plan; None if all may be."""
        self._actions: list[tuple[str, Past]] = []
        """The actor of each action, and what the action depends on."""

    def take(self, step: Step) -> None:
        """Note a step, in the trace's order."""
        cause = self._steps.get(step.cause or 0)
        same_agent = cause is not None and cause.agent == step.agent and cause.kind != "message"
        line = self._line_of[cause.number] if cause is not None and same_agent else step.number
        past = self._line_past[line] | (self._past[cause.number] if cause is not None else _NOTHING)
        if step.kind == "plan":
            self._plan_names[step.number] = self._names.get(step.agent, {}).get(step.place)
            past |= self._name(step.agent, step.number)
            self._plans_of_line[line].append(step.number)
        elif cause is not None and cause.kind == "plan":
            past |= self._name(step.agent, cause.number) | self._end(step.agent, line, cause.number)
        if step.kind == "belief":
            believed = self._believed[step.agent]
            functor = _functor(step.text[1:])
            believed[functor] = believed.get(functor, _NOTHING) | past
        self._steps[step.number], self._past[step.number], self._line_of[step.number] = step, past, line
        if step.kind == "action" and step.agent in self._actors:
            self._actions.append((step.agent, past))
            past |= {len(self._actions)}
        self._line_past[line] = past
        if step.kind == "message":
            self._send(step, line, past)

    def _end(self, agent: str, line: int, plan_step: int) -> Past:
        """Dependencies of plans that were chosen later in the line and have ended, since an earlier one continues: the
        last wait of such a plan has no step of its own."""
        plans = self._plans_of_line[line]
        ended: list[int] = []
        while plan_step in plans and plans[-1] != plan_step:
            ended.append(plans.pop())
        return _NOTHING.union(*(self._name(agent, plan) for plan in ended))

    def _send(self, step: Step, line: int, past: Past) -> None:
        """A message: an answer goes to the line that has asked, without an event."""
        content, _, receiver = step.text.rpartition(" to ")
        if content.startswith("ask"):
            self._asking[receiver, step.agent].append(line)
        for asking in self._asking[step.agent, receiver]:
            self._line_past[asking] |= past

    def _name(self, agent: str, plan_step: int) -> Past:
        names, believed = self._plan_names.get(plan_step), self._believed[agent]
        pasts = [past for functor, past in believed.items() if names is None or functor in names]
        return _NOTHING.union(*pasts)

    def direct(self) -> dict[int, tuple[int, ...]]:
        """The dependencies that do not follow from others, or from the order within a lane."""
        order: dict[int, tuple[int, ...]] = {}
        full: list[Past] = []
        """All actions that come before each action, including those of its own lane."""
        last: dict[str, int] = {}
        for number, (actor, past) in enumerate(self._actions, 1):
            before = {last[actor]} if actor in last else set()
            everything = past | before
            implied = _NOTHING.union(*(full[cause - 1] for cause in everything))
            others = sorted(c for c in everything - implied - before if self._actions[c - 1][0] != actor)
            if others:
                order[number] = tuple(others)
            full.append(everything | implied)
            last[actor] = number
        return order


def _functor(literal: str) -> str:
    return literal.lstrip("~").partition("(")[0].partition("[")[0]


def _names_of_plans(program: Program) -> dict[str, set[str]]:
    """Place of each plan -> the names in it, with those that rules derive them from."""
    derived: dict[str, set[str]] = defaultdict(set)
    for belief in program.beliefs:
        if not isinstance(belief, Structure):  # a rule: its head holds if its body does
            functors = functors_of(belief)
            for functor in functors:
                derived[functor] |= set(functors)
    names: dict[str, set[str]] = defaultdict(set)
    for plan in program.plans:  # several may be at one place: a place is a line
        names[place_of_plan(plan)] |= _close(functors_of(plan), derived.get)
    return dict(names)


def _close(names: Collection[str], derived: Callable[[str], Collection[str] | None]) -> set[str]:
    closed: set[str] = set()
    pending = list(names)
    while pending:
        name = pending.pop()
        if name not in closed:
            closed.add(name)
            pending += derived(name) or ()
    return closed
