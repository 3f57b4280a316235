"""Internal actions on the agents of a run: who takes part, and who offers what."""

from __future__ import annotations

from pytest_hricdv.bdi.actions.registry import Invocation, internal_action
from pytest_hricdv.bdi.agent.agent_state import Outcome
from pytest_hricdv.bdi.agent.directory import DIRECTORY
from pytest_hricdv.bdi.agent.intentions import SpeechAct
from pytest_hricdv.bdi.language.errors import EvaluationError
from pytest_hricdv.bdi.language.terms import ListTerm, String, Structure


@internal_action("create_agent", 2, inspects=True)
def _create_agent(invocation: Invocation) -> Outcome:
    """``.create_agent(Name, "source.asl")``; the agent acts from the next round on, as the last."""
    if invocation.is_free(0) or invocation.is_free(1):
        raise EvaluationError(f"{invocation.call}: expected a name and a source, found a variable without a value")
    invocation.agent.run.create_agent(invocation.text(0), invocation.text(1), invocation.call.location)
    return True


@internal_action("kill_agent", 1, inspects=True)
def _kill_agent(invocation: Invocation) -> Outcome:
    return invocation.agent.run.kill_agent(invocation.text(0))


@internal_action("clone", 1, inspects=True)
def _clone(invocation: Invocation) -> Outcome:
    """``.clone(Name)``: another agent with the beliefs and plans of this one; it acts from the next round on."""
    if invocation.is_free(0):
        raise EvaluationError(f"{invocation.call}: expected a name, found a variable without a value")
    invocation.agent.run.clone_agent(invocation.agent.name, invocation.text(0), invocation.call.location)
    return True


@internal_action("stopMAS", 0, 1)
def _stop_mas(invocation: Invocation) -> Outcome:
    if invocation.args and invocation.number(0) < 0:
        raise EvaluationError(f"{invocation.call}: a delay cannot be negative")
    invocation.agent.run.stop()
    return True


# The directory of who offers what, of agents that are providers of services. As in Jason's own infrastructure, the type
# of a service is read and makes no difference.


@internal_action("df_register", 1, 2, inspects=True)
def _df_register(invocation: Invocation) -> Outcome:
    run, service = invocation.agent.run, invocation.text(0)
    run.directory.register(invocation.agent.name, service)
    for subscriber in run.directory.subscribers(service):
        _tell_provider(invocation, subscriber, invocation.agent.name)
    run.progress += 1
    return True


@internal_action("df_deregister", 1, 2, inspects=True)
def _df_deregister(invocation: Invocation) -> Outcome:
    invocation.agent.run.directory.deregister(invocation.agent.name, invocation.text(0))
    invocation.agent.run.progress += 1
    return True


@internal_action("df_search", 2, 3, inspects=True)
def _df_search(invocation: Invocation) -> Outcome:
    """``.df_search(Service, Agents)``: the list of those who offer it, in the order of their names."""
    names = invocation.agent.run.directory.providers(invocation.text(0))
    return invocation.unify(len(invocation.args) - 1, ListTerm(tuple(map(Structure, names))))


@internal_action("df_subscribe", 1, 2, inspects=True)
def _df_subscribe(invocation: Invocation) -> Outcome:
    """The agent is told ``provider(Agent, "service")`` by ``df``, for those who offer it now and from now on."""
    run, service = invocation.agent.run, invocation.text(0)
    run.directory.subscribe(invocation.agent.name, service)
    for provider in run.directory.providers(service):
        _tell_provider(invocation, invocation.agent.name, provider)
    run.progress += 1
    return True


def _tell_provider(invocation: Invocation, subscriber: str, provider: str) -> None:
    run = invocation.agent.run
    run.messages += 1
    content = Structure("provider", (Structure(provider), String(invocation.text(0))))
    run.deliver(subscriber, SpeechAct(DIRECTORY, "tell", content, run.messages))
