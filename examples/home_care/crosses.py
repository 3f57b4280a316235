"""What is to have come together: orders and what follows them, the dog and the pace; orders and how they ended."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from carebot.tasks import ENDED, TASKS

from pytest_hricdv.runtime import RecordedMessage
from pytest_hricdv.testbench import CrossProduct

UNKNOWN, NONE = "unknown", "none"
ORDERS = (*TASKS, UNKNOWN)
COMPLETED, GIVEN_UP, REFUSED = "completed", "given up", "refused"
AFTERWARDS, MEANWHILE = "afterwards", "meanwhile"
AWAY, MET = "away", "met"

CROSS = {
    "orders": CrossProduct(
        {"order": tuple(TASKS), "next": (*ORDERS, NONE), "pace": (AFTERWARDS, MEANWHILE), "dog": (AWAY, MET)},
        impossible={
            (order, NONE, MEANWHILE, dog): "where nothing is ordered, nothing is meanwhile"
            for order in TASKS
            for dog in (AWAY, MET)
        },
    ),
    "ends": CrossProduct(
        {"order": ORDERS, "end": (COMPLETED, GIVEN_UP, REFUSED)},
        impossible={(UNKNOWN, end): "it is never accepted" for end in (COMPLETED, GIVEN_UP)},
    ),
}
"""`orders`: an order that was carried out or given up, the next one, when that came, and whether the dog was met."""


@dataclass(frozen=True)
class Served:
    """An order: what it was, when it came (s), how it ended and when (s)."""

    kind: str
    came_s: float
    end: str
    ended_s: float


def served(messages: Iterable[RecordedMessage]) -> tuple[Served, ...]:
    """The orders that the robot answered, in the order in which they came; open ones are left out.

    It carries out what it accepts in that order, so the first that is open is the one that ends.
    """
    orders: list[Served] = []
    unanswered: list[tuple[str, float]] = []
    waiting: list[tuple[str, float]] = []
    for message in messages:
        if message.is_disturbance:
            continue
        if message.topic == "order" and message.fields["kind"] != ENDED:
            unanswered.append((str(message.fields["kind"]), message.time_s))
        elif message.topic == "accepted" and unanswered and message.fields["order"] != ENDED:
            waiting.append(unanswered.pop(0))
        elif message.topic == "completed" and waiting:
            orders.append(Served(*waiting.pop(0), COMPLETED, message.time_s))
        elif message.topic == "refused" and unanswered and unanswered[0][0] == message.fields["order"]:
            orders.append(Served(*unanswered.pop(0), REFUSED, message.time_s))
        elif message.topic == "refused" and waiting:
            orders.append(Served(*waiting.pop(0), GIVEN_UP, message.time_s))
    return tuple(sorted(orders, key=lambda order: order.came_s))


def bins(messages: Sequence[RecordedMessage], dog_met_s: Sequence[float]) -> dict[str, list[tuple[str, ...]]]:
    """The bins that a run hits.

    Args:
        messages: of the run.
        dog_met_s: when the dog was near to the driving robot (s).
    """
    orders = served(messages)
    pairs: list[tuple[str, ...]] = []
    for number, order in enumerate(orders):
        after = orders[number + 1] if number + 1 < len(orders) else None
        if order.kind in TASKS and order.end != REFUSED:
            pace = MEANWHILE if after is not None and after.came_s < order.ended_s else AFTERWARDS
            met = any(order.came_s <= time_s <= order.ended_s for time_s in dog_met_s)
            pairs.append((order.kind, NONE if after is None else _kind(after), pace, MET if met else AWAY))
    return {"orders": pairs, "ends": [(_kind(order), order.end) for order in orders]}


def _kind(order: Served) -> str:
    return order.kind if order.kind in TASKS else UNKNOWN
