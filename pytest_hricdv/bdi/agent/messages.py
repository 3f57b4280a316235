"""Speech acts: `send` passes a message to another agent, `receive` processes it in the receiver's reasoning cycle.

The internal action ``.send`` calls `send`, `Agent` calls `receive`. ``tell``, ``achieve`` and ``signal`` take effect at
once; for other forces (kinds of messages) the receiver gets a goal ``+!kqml_received(Sender, Force, Content, Number)``,
for which every agent has the plans of ``kqml.asl``, after its own.
"""

from __future__ import annotations

from functools import lru_cache

from pytest_hricdv.bdi.agent.agent_state import AgentState
from pytest_hricdv.bdi.agent.failures import fail
from pytest_hricdv.bdi.agent.intentions import PendingQuestion, SpeechAct
from pytest_hricdv.bdi.language.errors import EvaluationError
from pytest_hricdv.bdi.language.terms import SOURCE_SELF, ListTerm, Number, String, Structure, Term, is_ground, source
from pytest_hricdv.bdi.logic.substitution import Bindings, free_variables, substitute_only
from pytest_hricdv.bdi.logic.unify import undo, unify

_DIRECT = frozenset({"tell", "achieve", "signal"})
"""The illocutionary forces that are processed without a plan."""


def add_source(content: Term, sender: str) -> Term:
    """The content with ``source(sender)``; for a list, each of its literals."""
    if isinstance(content, Structure):
        return with_source(content, sender)
    if isinstance(content, ListTerm):
        return ListTerm(tuple(add_source(item, sender) for item in content.items), content.tail)
    return content


def with_source(literal: Structure, sender: str) -> Structure:
    """A literal as it is received from an agent: ``a[source(b)]`` from c becomes ``a[source(c)[source(b)]]``."""
    sources = tuple(annot for annot in literal.annots if is_source(annot))
    if not sources:
        return literal.with_annotations((*literal.annots, source(sender)))
    others = tuple(annot for annot in literal.annots if annot not in sources)
    nested = source(sender).with_annotations(sources)
    return literal.with_annotations((*others, nested), literal.annots_tail)


def is_source(annot: Term) -> bool:
    """Whether an annotation is a source."""
    return isinstance(annot, Structure) and annot.key == SOURCE_SELF.key


_ground_with_source = lru_cache(maxsize=4096)(with_source)
"""Like :func:`with_source`, for ground literals: the same ones are told again and again. Others are not shared, because
plan terms may be equal although they are from different places in the sources."""


def send(agent: AgentState, receiver: str, force: str, content: Term, reply_to: str = "") -> SpeechAct:
    """Send a message on its way to the receiver's mailbox; it is visible from the receiver's next cycle.

    Returns:
        The message; an answer refers to its name.

    Raises:
        EvaluationError: there is no such agent.
    """
    to = agent.name if receiver == "self" else receiver
    if to not in agent.run.agents:
        raise EvaluationError(f"there is no agent {receiver} to send to", "receiver_not_found")
    if not is_ground(content):
        # The receiver's plans may have variables of the same names as the sender's.
        renaming: Bindings = {variable: agent.fresh() for variable in free_variables(content)}
        content = substitute_only(content, renaming) if renaming else content
    agent.run.messages += 1
    sender = "self" if to == agent.name else agent.name
    message = SpeechAct(sender, force, content, agent.run.messages, reply_to)
    agent.run.deliver(to, message)
    return message


def receive(agent: AgentState, message: SpeechAct) -> None:
    """Act on one message."""
    if message.reply_to:
        question = agent.questions.pop(message.reply_to, None)
        if question is not None:
            _take_answer(agent, question, message)
            return
    content, force = message.content, message.force
    if not is_processed_directly(agent, message):
        args = (Structure(message.sender), Structure(message.force), content, Structure(message.name))
        agent.post("+!", Structure("kqml_received", args), None)
        return
    if force == "tell" and content.ground:  # type: ignore[union-attr]
        agent.believe(_ground_with_source(content, message.sender))
        return
    literal = with_source(content, message.sender)  # type: ignore[arg-type]
    if force == "tell":
        agent.believe(literal)
    elif force == "achieve":
        agent.post_goal(literal)
    else:
        agent.post("+", literal, None)


def is_processed_directly(agent: AgentState, message: SpeechAct) -> bool:
    """Whether a message is processed without plans for messages."""
    direct = message.force in _DIRECT and isinstance(message.content, Structure)
    return direct and not agent.library.has_own_message_plans


def _take_answer(agent: AgentState, question: PendingQuestion, message: SpeechAct) -> None:
    """Resume an intention that waited for answers, once all agents that it asked have answered."""
    content: Term = message.content
    if message.force == "untell" and question.force == "askOne":
        content = Structure("false")
    elif isinstance(content, (Structure, ListTerm)):
        content = add_source(content, agent.name if message.sender == "self" else message.sender)
    if question.asked is not None:
        question.answers.append(content)
        if len(question.answers) < question.asked:
            return
        content = ListTerm(tuple(question.answers))
    intention = question.intention
    means = intention.top
    trail: list[object] = []
    if unify(question.answer, content, means.unifier, trail):  # type: ignore[arg-type]
        agent.resume(intention)
    else:
        undo(means.unifier, trail, 0)  # type: ignore[arg-type]
        fail(agent, intention, "ask_failed", f"the answer {content} is not a {question.answer}")


def text_of(term: Term) -> str:
    """The name in an atom or a string."""
    if isinstance(term, Structure) and not term.args:
        return term.functor
    if isinstance(term, String):
        return term.value
    if isinstance(term, Number):
        return str(term)
    raise EvaluationError(f"{term} is not a name", "wrong_arguments")
