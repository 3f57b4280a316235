"""Reads events as lines of JSON from standard input, and writes commands to standard output."""

import json
import sys

from pydantic import ValidationError

from walker.controller import WalkerController


def main() -> int:
    controller = WalkerController()
    for line in sys.stdin:
        try:
            commands = controller.feed(line)
        except ValidationError as error:
            print(json.dumps({"error": error.error_count()}), file=sys.stderr)
            continue
        for command in commands:
            print(json.dumps(command), flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
