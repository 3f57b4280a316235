"""Takes calls of patients from a web socket and sends a robot; functions and a table, no classes."""

import asyncio
import json
import time

import websockets

ROBOT = {"state": "free", "room": None, "since": 0.0}
QUEUE = []
HANDLERS = {}


def handles(kind):
    def register(function):
        HANDLERS[kind] = function
        return function

    return register


def become(state, room=None):
    ROBOT.update(state=state, room=room, since=time.monotonic())


@handles("call")
async def call(ws, data):
    room = data["room"]
    if data.get("reason") == "fall":
        become("alarm", room)
        await ws.send(json.dumps({"type": "alarm", "room": room}))
    elif ROBOT["state"] == "free":
        become("going", room)
        await ws.send(json.dumps({"type": "go", "room": room}))
    else:
        QUEUE.append(room)
        await ws.send(json.dumps({"type": "wait", "place": len(QUEUE)}))


@handles("arrived")
async def arrived(ws, data):
    if ROBOT["state"] == "going":
        become("visiting", ROBOT["room"])


@handles("answer")
async def answer(ws, data):
    if ROBOT["state"] != "visiting":
        return
    if data["word"] in ("water", "blanket", "nurse"):
        become("fetching", ROBOT["room"])
        await ws.send(json.dumps({"type": "fetch", "what": data["word"]}))
    elif data["word"] == "nothing":
        await done(ws, data)


@handles("done")
async def done(ws, data):
    become("free")
    if QUEUE:
        await call(ws, {"room": QUEUE.pop(0)})


@handles("quit_alarm")
async def quit_alarm(ws, data):
    if ROBOT["state"] == "alarm" and data.get("staff"):
        become("free")


async def session(ws):
    async for raw in ws:
        try:
            data = json.loads(raw)
            handler = HANDLERS[data["type"]]
        except (ValueError, KeyError):
            await ws.send(json.dumps({"type": "error"}))
            continue
        await handler(ws, data)


async def main(port=8700):
    async with websockets.serve(session, "", port):
        await asyncio.Future()


if __name__ == "__main__":
    asyncio.run(main())
