import asyncio

from kiosk.server import Kiosk


def test_order():
    async def scene():
        kiosk = Kiosk()
        print(await kiosk.handle({"verb": "order", "flavour": "mango"}))
        await kiosk.handle({"verb": "open"})
        assert "missing" in await kiosk.handle({"verb": "order", "flavour": "vanilla", "cone": False})
        await kiosk.handle({"verb": "pay", "coins": 3})
        assert await kiosk.handle({"verb": "order", "flavour": "vanilla", "cone": False}) == {"done": "vanilla"}
        await kiosk.handle({"verb": "close"})

    asyncio.run(scene())
