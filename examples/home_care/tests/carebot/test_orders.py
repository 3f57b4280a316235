"""The order desk: each order is answered at once, and what is accepted waits for its turn."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable

import pytest
from carebot.bus import Bus
from carebot.config import SWITCHES, Config, Faults, faults
from carebot.messages import Accepted, Order, Refused
from carebot.orders import ENDING, FULL, LATE, UNKNOWN, OrderDesk

Use = Callable[[OrderDesk, Callable[[str], Awaitable[None]]], Awaitable[None]]


def answers(use: Use, config: Config | None = None) -> list[object]:
    """What the desk says while it is used; `use` gets it, and says what is ordered."""
    said: list[object] = []

    async def main() -> None:
        bus = Bus()
        bus.listen(lambda message: said.append(message) if isinstance(message, (Accepted, Refused)) else None)
        desk = OrderDesk(bus, config or Config())
        serving = asyncio.create_task(desk.serve())

        async def order(kind: str) -> None:
            bus.publish(Order(kind))
            await asyncio.sleep(0)
            await asyncio.sleep(0)

        await use(desk, order)
        serving.cancel()

    asyncio.run(main())
    return said


def test_orders_wait_in_their_order() -> None:
    taken: list[str] = []

    async def use(desk: OrderDesk, order: Callable[[str], Awaitable[None]]) -> None:
        desk.busy = True
        for kind in ("feed", "sink", "feed"):
            await order(kind)
        while desk.has_some:
            taken.append(desk.take().kind)

    assert answers(use) == [Accepted("feed"), Accepted("sink"), Accepted("feed")]
    assert taken == ["feed", "sink", "feed"]


def test_what_it_cannot_do_is_refused_with_a_reason() -> None:
    async def use(desk: OrderDesk, order: Callable[[str], Awaitable[None]]) -> None:
        await order("chase")
        assert not desk.has_some

    assert answers(use) == [Refused("chase", UNKNOWN)]


def test_so_is_an_order_too_many_and_one_after_the_last_one_but_never_the_end() -> None:
    async def use(desk: OrderDesk, order: Callable[[str], Awaitable[None]]) -> None:
        for kind in ("fridge", "sink", "feed", "ended", "clean"):
            await order(kind)

    said = answers(use, Config(queue=2))
    assert said == [
        Accepted("fridge"),
        Accepted("sink"),
        Refused("feed", FULL),
        Accepted("ended"),
        Refused("clean", ENDING),
    ]


def test_an_order_that_has_waited_too_long_is_given_up_but_never_the_end() -> None:
    async def use(desk: OrderDesk, order: Callable[[str], Awaitable[None]]) -> None:
        await order("sink")
        await order("ended")
        await order("feed")
        assert desk.take().kind == "ended"
        assert not desk.has_some

    said = answers(use, Config(order_limit_s=0.0))
    assert said == [Accepted("sink"), Refused("sink", LATE), Accepted("ended"), Refused("feed", ENDING)]


def test_the_published_fault_loses_an_order_without_a_word_while_it_is_busy() -> None:
    async def use(desk: OrderDesk, order: Callable[[str], Awaitable[None]]) -> None:
        await order("fridge")
        desk.busy = True
        await order("sink")
        await order("ended")

    assert answers(use, Config(faults=Faults(loses_orders=True))) == [Accepted("fridge"), Accepted("ended")]


def test_faults_are_off_unless_named_and_a_wrong_name_is_refused() -> None:
    assert faults("") == Faults()
    assert faults(",".join(SWITCHES)) == Faults(True, True, True, True, True)
    with pytest.raises(ValueError, match="no fault 'stops'; expected some of stop-on-either"):
        faults("stops")
