"""Fuzz all parsers and loaders.

    python -m benchmarks.fuzz [--inputs N] [--seed N] [--only TARGET] [--findings DIR]

Each input is a function of the seed and its number. A finding is an error that is not documented, a message of more
than 1,000 characters or with control characters, more than 5 s, or more than 500 MB; its input is kept. Exit status 1
if there is any.
"""

from __future__ import annotations

import argparse
import resource
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from types import FrameType

from benchmarks.fuzz.targets import Target, draw, targets

# Chosen: what is worth a bug report. Inputs are small: a reader takes milliseconds and some MB for them, and a message
# of more than ten lines hides what is wrong.
LIMIT_S = 5.0
LIMIT_BYTES = 500_000_000
LONGEST_MESSAGE = 1_000


class TooLongError(BaseException):
    """An input took too long. No Exception: nothing that reads input may catch it."""


@dataclass
class FuzzCounts:
    """What happened: inputs and refused ones by target, findings by kind with their first input, and the slowest."""

    inputs: Counter[str] = field(default_factory=Counter)
    refused: Counter[str] = field(default_factory=Counter)
    findings: Counter[str] = field(default_factory=Counter)
    slowest_s: dict[str, float] = field(default_factory=dict)


def fuzz(inputs: int, seed: int, chosen: dict[str, Target], folder: Path, findings: Path) -> FuzzCounts:
    """Read so many inputs; see the module.

    Args:
        inputs: how many.
        seed: of all random choices.
        chosen: targets by name.
        folder: for files.
        findings: folder for inputs that led to a finding; created where there is one.
    """
    tally, names = FuzzCounts(), sorted(chosen)
    for number in range(inputs):
        rng = Random(f"{seed}:{number}")
        name = rng.choice(names)
        text = draw(chosen[name], rng)
        tally.inputs[name] += 1
        began_s = time.perf_counter()
        finding, refused = _read(chosen[name], text, folder / "input.txt")
        tally.slowest_s[name] = max(tally.slowest_s.get(name, 0.0), time.perf_counter() - began_s)
        tally.refused[name] += refused
        if finding:
            finding = f"{name}: {finding}"
            tally.findings[finding] += 1
            if tally.findings[finding] == 1:
                findings.mkdir(parents=True, exist_ok=True)
                kept = findings / f"{seed}-{number}.txt"
                kept.write_text(text, "utf-8", "surrogatepass")
                print(f"{kept}: {finding}", flush=True)
    return tally


def _read(target: Target, text: str, path: Path) -> tuple[str, bool]:
    """What is wrong with how an input was read, and whether it was refused."""
    try:
        with _time_limit():
            target.read(text, path)
    except target.errors as error:
        message = str(error)
        if len(message) > LONGEST_MESSAGE:
            return f"a message of {len(message)} characters", True
        odd = [char for char in message if not (char.isprintable() or char in "\n\t")]
        return (f"a message with {odd[0]!r}", True) if odd else ("", True)
    except TooLongError:
        return f"more than {LIMIT_S} s", False
    except MemoryError:
        return f"more than {LIMIT_BYTES / 1e6:.0f} MB", False
    except Exception as error:
        frames = [frame for frame in traceback.extract_tb(error.__traceback__) if "pytest_hricdv" in frame.filename]
        place = f"{Path(frames[-1].filename).name}:{frames[-1].lineno}" if frames else "nowhere"
        return f"{type(error).__name__} at {place}", False
    return "", False


@contextmanager
def _time_limit() -> Iterator[None]:
    def end(signal_number: int, frame: FrameType | None) -> None:
        raise TooLongError

    before = signal.signal(signal.SIGALRM, end)
    signal.setitimer(signal.ITIMER_REAL, LIMIT_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def main() -> int:
    """Fuzz, and print what was found."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--inputs", type=int, default=10_000, metavar="N", help="how many (default 10000)")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="of all inputs (default 0)")
    parser.add_argument("--only", metavar="TARGET", help="this parser or loader only")
    parser.add_argument("--findings", type=Path, default=Path("fuzz-findings"), metavar="DIR", help="for inputs")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        chosen = targets(Path(folder))
        chosen = {name: target for name, target in chosen.items() if options.only in (None, name)}
        # Beside what is in use: the imports alone take more than some limits.
        used = int(Path("/proc/self/statm").read_text("ascii").split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (used + LIMIT_BYTES, used + LIMIT_BYTES))
        began_s = time.perf_counter()
        tally = fuzz(options.inputs, options.seed, chosen, Path(folder), options.findings)
    for name in sorted(tally.inputs):
        counts = f"{tally.inputs[name]:>9} inputs{tally.refused[name]:>9} refused"
        print(f"{name:14}{counts}, {tally.slowest_s[name]:.2f} s at most")
    print(f"seed {options.seed}: {tally.inputs.total()} inputs in {time.perf_counter() - began_s:.0f} s")
    for finding, count in tally.findings.most_common():
        print(f"FINDING {count} times: {finding}")
    return 1 if tally.findings else 0


if __name__ == "__main__":
    sys.exit(main())
