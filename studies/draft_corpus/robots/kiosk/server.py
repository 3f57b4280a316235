"""An ice-cream kiosk: customers' screens connect by TCP and talk in lines of JSON."""

import asyncio
import enum
import json


class Phase(enum.Enum):
    CLOSED = "closed"
    READY = "ready"
    SERVING = "serving"
    CLEANING = "cleaning"


PRICES = {"vanilla": 2, "mango": 3, "pistachio": 3}


class Kiosk:
    def __init__(self, host: str = "127.0.0.1", port: int = 8765) -> None:
        self.host = host
        self.port = port
        self.phase = Phase.CLOSED
        self.served = 0
        self.paid = 0

    async def run(self) -> None:
        server = await asyncio.start_server(self.client, self.host, self.port)
        async with server:
            await server.serve_forever()

    async def client(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        while True:
            line = await reader.readline()
            if not line:
                break
            try:
                request = json.loads(line)
            except ValueError:
                await self.reply(writer, {"error": "not JSON"})
                continue
            await self.reply(writer, await self.handle(request))
        writer.close()

    async def reply(self, writer, answer: dict) -> None:
        writer.write(json.dumps(answer).encode() + b"\n")
        await writer.drain()

    async def handle(self, request: dict) -> dict:
        verb = request.get("verb")
        if verb == "open" and self.phase is Phase.CLOSED:
            self.phase = Phase.READY
        elif verb == "close":
            self.phase = Phase.CLOSED
        elif verb == "pay":
            self.paid += int(request.get("coins", 0))
            return {"credit": self.paid}
        elif verb == "order":
            return await self.order(request.get("flavour"), request.get("cone", True))
        else:
            return {"error": "what?"}
        return {"phase": self.phase.value}

    async def order(self, flavour: str, cone: bool) -> dict:
        if self.phase is not Phase.READY:
            return {"error": "not ready"}
        price = PRICES.get(flavour)
        if price is None:
            return {"error": "no such flavour"}
        if self.paid < price:
            return {"error": "please pay", "missing": price - self.paid}
        self.paid -= price
        self.phase = Phase.SERVING
        await asyncio.sleep(4.0 if cone else 3.0)
        self.served += 1
        if self.served % 3 == 0:
            self.phase = Phase.CLEANING
            await asyncio.sleep(10.0)
        self.phase = Phase.READY
        return {"done": flavour}


if __name__ == "__main__":
    asyncio.run(Kiosk().run())
