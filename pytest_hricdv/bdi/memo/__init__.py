"""`Memo` runs a model many times, and reuses recorded segments of earlier runs.

Purpose
    Learning runs a model thousands of times with different sets of beliefs, and most sets change only a small part of
    a run. These runs differ only in the atoms ``b`` of the percepts ``f(b)`` of one agent, the steering agent, which
    forwards them to others: ``for (f(B)) { .send(human, tell, B) }``.

How it works
    A run is cut into segments between rounds, where a receiver of forwarded atoms has just begun to pursue a goal or is
    about to: there it is most often in a state that occurred before, and has made no query yet. A node stands for the
    mental state of all agents at such a cut, an edge for a segment: what was printed, done and executed, and how many
    rounds it took. Within a segment, each query of a receiver for an atom that may be forwarded is recorded with its
    answer, and the answers decide which edge a run takes. So the nodes are a decision diagram over the set of atoms. A
    run follows the diagram from the root for its number of atoms. Where an edge is missing, the agents are put into the
    state of that node, and the model is executed up to the next node only: so each segment is executed once.

Why it is equal
    Let S be the set of atoms. The state at a node is a function of the node and of S: a receiver's belief is either
    as S says, if nothing but forwarding has changed it, or what the node says. What happens next can depend on
    S only through

    - the number of atoms, before all have arrived: there is a root for each number;
    - the atoms in the steering agent: its program mentions ``f`` nowhere but in such loops, and their variable
      only as the content of messages, so no condition, goal or text can depend on it;
    - the beliefs of receivers: every query of one that is still as S says is recorded.

    Two sets that answer the queries of a segment equally thus have equal segments, and states at its end that
    are the same node. A segment is only added if this is certain. It is not if

    - a receiver queries before all atoms have arrived, an atom arrives twice, or something waits for it;
    - an atom has a meaning for the receiver when it comes: there is a plan for it, or it is believed at first;
    - an agent uses what is different in every run or segment: the clock, random numbers, new variables, the numbers
      of messages;
    - an agent inspects or changes intentions or plans;
    - the steering agent queries its percepts a second time, or not at all;
    - there is no progress for enough rounds that the run might have been checked for a livelock, which
      happens at certain rounds of a run and so depends on how long it took before;
    - the round limit is reached;
    - it does enough work in few rounds that a run of such segments could reach the limit of work.

    Such runs, and runs with other percepts, are executed and remembered as a whole, by all that they are given.
    A custom environment may do anything: with it nothing is remembered.
"""

from pytest_hricdv.bdi.memo.decision_diagram import Fold, Runs, TooLargeError
from pytest_hricdv.bdi.memo.memo import Memo

__all__ = ["Fold", "Memo", "Runs", "TooLargeError"]
