"""`RecordingRun` executes a run segment by segment, and records each for the memo's decision diagram.

`Memo` starts one where a segment is missing; `record` gives the segment and the agents' states at its end.
"""

from __future__ import annotations

from collections.abc import Sequence

from pytest_hricdv.bdi.actions import StandardActions
from pytest_hricdv.bdi.actions.registry import ACTIONS
from pytest_hricdv.bdi.agent.agent import Agent
from pytest_hricdv.bdi.agent.agent_state import AgentState
from pytest_hricdv.bdi.agent.intentions import ActionResult, Intention, Outcome, SpeechAct
from pytest_hricdv.bdi.agent.messages import is_processed_directly
from pytest_hricdv.bdi.language.terms import Call, Structure, Variable
from pytest_hricdv.bdi.logic.beliefs import BeliefBase
from pytest_hricdv.bdi.logic.substitution import Bindings
from pytest_hricdv.bdi.logic.unify import Trail
from pytest_hricdv.bdi.memo.decision_diagram import Segment
from pytest_hricdv.bdi.memo.forwarding import Dependencies, ReceiverBeliefs, SteeringBeliefs
from pytest_hricdv.bdi.memo.snapshot import AgentSnapshot, restore, snapshot
from pytest_hricdv.bdi.run.environment import Environment
from pytest_hricdv.bdi.run.livelock import QUIET_ROUNDS
from pytest_hricdv.bdi.run.system import AgentTemplate
from pytest_hricdv.bdi.run.system_run import SystemRun

_CUT = "cut"
"""The ending of a run at the end of a segment, from where it can be continued."""
_UNCERTAIN = "uncertain"
"""The ending of a run whose segments must not be reused, since other beliefs might change them."""
_SHORTEST = 3
"""Least number of rounds of a segment: an agent that begins a goal often still counts as beginning in the next round.

Only speed depends on this and the next two. For 600 random belief sets of the table (`random_sets(600, 3)` of
`tests/bdi/memo/test_memo.py`), 13,965 of 105,944 rounds are executed; with 1 to 10 here, 13,959 to 14,375; with 30,
42,726.
"""
_LONG = 100
"""Rounds after which a segment may end while a receiver pursues a goal: values from 20 to 1,000 change nothing."""
_QUIET_BEFORE = 10
"""Most rounds without progress before the beginning of a segment. It has to be less than :data:`QUIET_ROUNDS`;
values from 1 to 20 change 12 of the 13,965 rounds, with 39 no run can be divided."""


class RecordingRun(SystemRun):
    """A run that is recorded in segments.

    Args:
        environment: the plain environment.
        seed: the seed of the run's random numbers.
        dependencies: where to note what the run depends on.
        states: the states of the agents to continue from; None at the beginning of a run.
    """

    def __init__(
        self,
        environment: Environment,
        seed: int,
        templates: Sequence[AgentTemplate],
        dependencies: Dependencies,
        states: tuple[AgentSnapshot, ...] | None,
    ) -> None:
        super().__init__(environment, seed)
        self.dependencies = dependencies
        self._quiet = 0 if states is None else _QUIET_BEFORE
        """An upper bound of the rounds since the last progress."""
        self._seen_progress = 0
        self._states: tuple[AgentSnapshot, ...] = ()
        forwarding, actions = dependencies.forwarding, _ActionRecorder(dependencies)
        for place, template in enumerate(templates):
            receives, steers = template.name in forwarding.receivers, template.name == forwarding.steering
            kind = _Receiver if receives else _SteererRecorder if steers else _AgentRecorder
            agent = template.agent(self, kind)
            agent.actions = actions
            self.agents[template.name] = agent
            content = template.beliefs if states is None else states[place].beliefs
            beliefs = BeliefBase(content)
            if receives:
                beliefs = ReceiverBeliefs(content, dependencies, () if states is None else dependencies.atoms)
            agent.beliefs = beliefs
            if states is not None:
                if steers:
                    beliefs = SteeringBeliefs(beliefs, dependencies)
                restore(agent, states[place], beliefs)

    # --- what is different in every run or segment

    @property
    def time_ms(self) -> float:
        """Virtual time."""
        self.dependencies.certain = False
        return super().time_ms

    def draw(self) -> float:
        """The next random number."""
        self.dependencies.certain = False
        return super().draw()

    def fresh(self) -> Variable:
        """A variable that occurs nowhere else in the run."""
        self.dependencies.certain = False
        return super().fresh()

    # --- segments

    def record(self, max_rounds: int) -> tuple[Segment, tuple[AgentSnapshot, ...] | None] | None:
        """Execute the next segment.

        Args:
            max_rounds: the rounds that it may take.

        Returns:
            The segment, and the states of the agents at its end if that is not the end of the run. None if it is not
            certain that other runs in this state with the same answers have the same segment: then
            the run cannot continue here.

        Raises:
            BdiError: an agent cannot continue.
        """
        ticks = self.ticks
        self.skipped, self.rounds = ticks, 0
        self._seen_progress = self.progress
        self.dependencies.answers = {}
        self.ended = ""
        ended = self.go(max_rounds)
        if ended == _CUT:
            self._quiet = _QUIET_BEFORE
            return self._segment(ticks, ""), self._states
        certain = self.dependencies.certain and self.dependencies.is_done
        if ended in ("idle", "spin") and certain and self.rounds < max_rounds:
            return self._segment(ticks, ended), None
        return None

    def do_round(self) -> bool:
        """Do a round, and decide whether the segment ends with it, or the run must not continue."""
        acted = super().do_round()
        if acted:
            self._end_round()
        return acted

    def _end_round(self) -> None:
        self._quiet += 1
        if self._quiet >= QUIET_ROUNDS:
            self.dependencies.certain = False
        if self.progress != self._seen_progress:
            self._seen_progress = self.progress
            self._quiet = 1
        if self.ended or not self.dependencies.certain:
            self.ended = _UNCERTAIN
        elif self._may_cut():
            self.ended = _CUT

    def _may_cut(self) -> bool:
        """Whether a receiver has just begun with something, or is about to: then it is most often in a known state."""
        if self._quiet > _QUIET_BEFORE or self.rounds < _SHORTEST or not self.dependencies.is_done:
            return False
        last = None
        for agent in self.agents.values():
            if agent.awake and (not agent.busy_waiting or agent.has_news()):
                last = agent
        if not isinstance(last, _Receiver) or self.ticks >= self.earliest_deadline:
            return False
        return (self.rounds >= _LONG or last.begins()) and self._find_states()

    def _find_states(self) -> bool:
        """Note the states of all agents before the next round; False if they cannot be compared."""
        steering = self.agents[self.dependencies.forwarding.steering]
        if steering.has_work() or steering.waits:
            # It could still be about to forward something.
            return False
        states = [snapshot(agent, self.ticks) for agent in self.agents.values()]
        self._states = tuple([state for state in states if state is not None])
        return len(self._states) == len(states)

    def _segment(self, since: int, ended: str) -> Segment:
        """The segment that ends here; ``since`` is the tick of its beginning."""
        plans = []
        for name, agent in self.agents.items():
            if agent.executed:
                plans.append((name, agent.executed))
                agent.executed = []
        rounds, ticks = self.rounds, self.ticks - since
        segment = Segment(rounds, ticks, self.prints, self.actions, self.warnings, plans, ended, self.endless)
        self.prints, self.actions, self.warnings = [], [], []
        return segment


class _ActionRecorder(StandardActions):
    """The internal actions in a recorded run; notes those whose results other runs must not reuse."""

    def __init__(self, dependencies: Dependencies) -> None:
        self._dependencies = dependencies

    def execute(self, agent: AgentState, call: Call, bindings: Bindings, intention: Intention) -> ActionResult:
        """Execute an internal action as a statement."""
        self._note(call)
        return super().execute(agent, call, bindings, intention)

    def solve(self, agent: AgentState, call: Call, bindings: Bindings, trail: Trail) -> Outcome:
        """Evaluate an internal action as a condition."""
        self._note(call)
        return super().solve(agent, call, bindings, trail)

    def _note(self, call: Call) -> None:
        action = ACTIONS.get(call.name)
        if action is None or action.inspects:
            self._dependencies.certain = False


class _AgentRecorder(Agent):
    """An agent in a recorded run; notes steps that other runs must not reuse."""

    run: RecordingRun

    def receive(self, message: SpeechAct) -> None:
        """Process a message; plans for messages can see its number, which is different in every run."""
        if message.reply_to or not is_processed_directly(self, message):
            self.run.dependencies.certain = False
        super().receive(message)


class _SteererRecorder(_AgentRecorder):
    """The agent that forwards its percepts."""

    def perceive(self) -> None:
        """Perceive; from then on queries of the percepts are noted."""
        super().perceive()
        self.beliefs = SteeringBeliefs(self.beliefs, self.run.dependencies)


class _Receiver(_AgentRecorder):
    """An agent to which atoms are forwarded."""

    beliefs: ReceiverBeliefs

    def receive(self, message: SpeechAct) -> None:
        """Process a message; a forwarded atom is believed without noting that."""
        dependencies = self.run.dependencies
        atom = message.content
        forwarded = message.sender == dependencies.forwarding.steering and message.force == "tell"
        if not forwarded or not isinstance(atom, Structure) or atom.functor not in dependencies.atoms:
            super().receive(message)
            return
        belief = dependencies.forwarding.belief(atom.functor)
        if atom.args or atom.negated or atom.annots or self.waits or self.beliefs.holds(belief.key):
            # It has come twice, the agent has come to believe it by itself, or something may wait for it.
            dependencies.certain = False
            super().receive(message)
        else:
            dependencies.missing -= 1
            self.beliefs.arrive(belief)
            self.run.progress += 1

    def begins(self) -> bool:
        """Whether it is not in the middle of anything: it only waited busily, or no plan of it pursues a goal."""
        if self.feedback:
            return False
        if self.busy_waiting:
            return True
        waiting = [intention for _, _, intention in self.events if intention is not None]
        return not any(len(intention.stack) > 1 for intention in waiting) and not any(
            len(intention.stack) > 1 or intention.top.sign in ("+!", "-!") for intention in self.intentions
        )
