"""The actions of a run, produced by the agent of the person when the person asks for them."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count

from pytest_hricdv.generate.concrete import ConcreteAction, Concretization, draw_action
from pytest_hricdv.online.online_agent import OnlineAgent
from pytest_hricdv.run import Run


class OnlineActions:
    """Produces the actions of one run (see `pytest_hricdv.run.Actions`); their parameters are drawn.

    Args:
        agent: of this run; it has to listen to it.
        commands: with the ranges of their parameters.
    """

    def __init__(self, agent: OnlineAgent, commands: Concretization) -> None:
        self._agent = agent
        self._commands = commands

    def __call__(self, run: Run, actor: str = "", /) -> Iterator[ConcreteAction]:
        """The actions, up to when the agent has nothing to do and nothing more to expect.

        Raises:
            InteractiveAgentError: the agent cannot go on.
            GenerateError: it does what is no command.
        """
        for place in count():
            command = self._next(run)
            if command is None:
                return
            yield draw_action(command, self._commands, run.test.seed, place)

    def _next(self, run: Run) -> str | None:
        command = self._agent.next_command(run.kernel.now_s)
        while command is None and run.waiting is not None:
            heard = self._agent.heard
            run.waiting()
            command = self._agent.next_command(run.kernel.now_s, waited=True)
            if self._agent.heard == heard:
                break
        return self._agent.let_time_pass() if command is None else command
