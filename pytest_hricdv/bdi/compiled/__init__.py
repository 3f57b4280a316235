"""The fast path: programs compiled to Python.

What is compiled
    The events of an agent become functions that find the first applicable plan, its plans functions that can be
    left after every statement and taken up there again. Beliefs without arguments are kept by name, the others
    in one table for each predicate.

What is left to the interpreter
    Agents with rules, with plans for any event, or with plans of their own for messages, are interpreted from
    the start. The others are compiled, and where a run comes to something without a compiled form, the agent
    hands over to the interpreter, with its whole mental state, for the rest of that run. These are: failures of
    any kind (no applicable plan, a false action or condition, an expression without a value), percepts that
    change during a run, messages other than ``tell`` and ``achieve``, atomic plans, goals with free variables,
    annotations other than one source, conditions with structured patterns or internal actions, and all internal
    actions but ``.print .println .send .abolish .wait(T)``.

Why it is equal
    A compiled agent has the interpreter's queues (mailbox, events, action feedback, intentions) and does the same
    reasoning cycle on them, so that several intentions interleave in the same way. It does several cycles at once
    only while its own queues are empty and nothing can come between: all other agents are idle, spin, or have got
    from it what makes them react but will keep to themselves for some cycles, see :mod:`.calm` and :mod:`.posting`.
    Whatever it cannot do exactly it has not begun when it hands over.

What makes it fast
    Where cycles enough are left for consecutive statements, they are done in one piece, see :mod:`.straight`; a goal is
    begun where it is posted; a plan with nothing left to do is forgotten where nobody can tell; a message that is sent
    again is the same object, with all that it means to its receiver. An agent that only looks again and again is left
    alone until something comes to it, see :mod:`pytest_hricdv.bdi.spinning`; so are interpreted ones.
"""

from .agent import CompiledAgent
from .code import AgentCode
from .compiler import compile_agent, compile_program
from .program import ProgramCode

__all__ = ["AgentCode", "CompiledAgent", "ProgramCode", "compile_agent", "compile_program"]
