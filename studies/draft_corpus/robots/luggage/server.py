"""Lets the reception's computer talk to the cart: one connection at a time, a line for each command and answer."""

import argparse
import json
import logging
import pathlib
import socketserver

import yaml

from luggage.cart import Cart
from luggage.commands import BadCommand, parse

logger = logging.getLogger(__name__)


class Reception(socketserver.StreamRequestHandler):
    def handle(self):
        cart = self.server.cart
        cart.listeners.append(self.tell)
        try:
            for line in self.rfile:
                try:
                    answer = cart.handle(parse(line.decode()))
                except BadCommand as error:
                    answer = f"error: {error}"
                self.send({"answer": answer})
        finally:
            cart.listeners.remove(self.tell)

    def tell(self, mode):
        self.send({"mode": mode})

    def send(self, content):
        self.wfile.write(json.dumps(content).encode() + b"\n")


class Server(socketserver.TCPServer):
    allow_reuse_address = True

    def __init__(self, address, cart):
        super().__init__(address, Reception)
        self.cart = cart


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--config", type=pathlib.Path, default=pathlib.Path(__file__).parent / "config.yaml")
    parser.add_argument("-v", "--verbose", action="store_true")
    options = parser.parse_args(argv)
    logging.basicConfig(level=logging.DEBUG if options.verbose else logging.INFO)
    config = yaml.safe_load(options.config.read_text())

    from hotel_drivers import Lift, Lock, Wheels

    cart = Cart(Wheels(), Lift(), Lock(), pin=config["pin"], floors=config["floors"])
    cart.start()
    with Server((config["host"], config["port"]), cart) as server:
        server.serve_forever()


if __name__ == "__main__":
    main()
