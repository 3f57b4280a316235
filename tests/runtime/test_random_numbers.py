"""Random numbers in a run depend on the seed of its test, whatever they are drawn with; outside nothing is changed."""

from __future__ import annotations

import importlib
import os
import random
import secrets
import subprocess
import sys
import tempfile
import threading
import uuid
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from os import urandom as alias
from pathlib import Path
from random import seed as seed_alias

import numpy as np
import pytest

from pytest_hricdv.runtime import Kernel
from pytest_hricdv.runtime.random_numbers import seed_run
from pytest_hricdv.runtime.virtual import clocks

ROOT = Path(__file__).parents[2]


def in_a_thread() -> float:
    drawn: list[float] = []
    thread = threading.Thread(target=lambda: drawn.append(random.random() + random.Random().random()))
    thread.start()
    thread.join()
    return drawn[0]


def in_a_pool() -> bytes:
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(os.urandom, 8).result()


def in_a_fork() -> bytes:
    reading, writing = os.pipe()
    pid = os.fork()
    if pid == 0:
        os.write(writing, f"{random.random()} {np.random.rand()} {os.urandom(4).hex()}".encode())
        os._exit(0)
    os.waitpid(pid, 0)
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        return pipe.read()


def seeded_anew(seed: Callable[[], None]) -> float:
    seed()
    return random.random()


def numpy_seeded_anew() -> float:
    np.random.seed()
    return float(np.random.rand())


class Dice(random.Random):
    """A generator of a user's own."""


DRAWS: dict[str, Callable[[], object]] = {
    "random.random": random.random,
    "random.seed()": lambda: seeded_anew(random.seed),
    "random.seed() imported by name": lambda: seeded_anew(seed_alias),
    "random.Random()": lambda: random.Random().random(),
    "a subclass of random.Random": lambda: Dice().random(),
    "random.SystemRandom": lambda: random.SystemRandom().random(),
    "os.urandom": lambda: os.urandom(16),
    "os.urandom imported by name": lambda: alias(16),
    "secrets.token_hex": secrets.token_hex,
    "uuid.uuid4": uuid.uuid4,
    "uuid.uuid1": lambda: uuid.uuid1(),
    "numpy.random.rand": lambda: float(np.random.rand()),
    "numpy.random.seed()": numpy_seeded_anew,
    "numpy.random.default_rng()": lambda: float(np.random.default_rng().random()),
    "numpy.random.RandomState()": lambda: float(np.random.RandomState().rand()),
    "numpy.random.PCG64()": lambda: str(np.random.PCG64().state),
    "tempfile.mktemp": lambda: next(tempfile._get_candidate_names()),  # type: ignore[attr-defined]
    "a thread": in_a_thread,
    "a pool of threads": in_a_pool,
}
if hasattr(os, "fork"):
    DRAWS["a fork"] = in_a_fork
if hasattr(os, "getrandom"):
    DRAWS["os.getrandom"] = lambda: os.getrandom(16)


@pytest.mark.parametrize("draw", DRAWS.values(), ids=DRAWS.keys())
def test_what_a_run_draws_depends_on_the_seed_of_its_test_only(draw: Callable[[], object]) -> None:
    def drawn(seed: int) -> list[object]:
        with seed_run(seed):
            return [draw(), draw()] if draw is not in_a_fork else [draw()]

    first = drawn(1)
    random.seed(5)
    np.random.seed(5)
    np.random.randn()
    assert drawn(1) == first
    assert drawn(2) != first
    assert len({str(value) for value in first}) == len(first)


@pytest.mark.parametrize("draw", DRAWS.values(), ids=DRAWS.keys())
def test_afterwards_everything_is_as_it_was(draw: Callable[[], object]) -> None:
    before = (random.getstate(), np.random.get_state(legacy=False), os.urandom, random.Random.seed, [*sys.meta_path])
    with pytest.raises(ZeroDivisionError), seed_run(1):
        print(draw(), 1 / 0)
    after = (random.getstate(), np.random.get_state(legacy=False), os.urandom, random.Random.seed, [*sys.meta_path])
    np.testing.assert_equal(after, before)
    assert len({os.urandom(8), os.urandom(8), alias(8), uuid.uuid4().bytes, random.Random().randbytes(8)}) == 5


def test_identifiers_keep_their_version() -> None:
    with seed_run(1):
        assert uuid.uuid4().version == 4


def test_threads_that_were_there_before_have_real_randomness() -> None:
    go_on, drawn = threading.Event(), []

    def work() -> None:
        go_on.wait()
        drawn.append(os.urandom(16))

    for _ in range(2):
        go_on.clear()
        thread = threading.Thread(target=work)
        thread.start()
        with seed_run(1):
            go_on.set()
            thread.join()
    assert drawn[0] != drawn[1]


def test_a_module_that_draws_when_imported_takes_nothing_from_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "hri_arm.py").write_text(
        "import os, random\nID = (random.random(), os.urandom(4), random.Random().random())\n"
    )
    monkeypatch.syspath_prepend(tmp_path)

    def run(seed: int) -> tuple[object, object]:
        with seed_run(seed):
            arm = importlib.import_module("hri_arm")
            return arm.ID, (random.random(), os.urandom(4))

    first = run(1)
    assert run(1)[1] == first[1]
    monkeypatch.delitem(sys.modules, "hri_arm")
    assert run(2)[0] == first[0], "what it drew is the same whichever test imports it first"
    spec = sys.modules["hri_arm"].__spec__
    assert spec is not None
    assert "exec_module" not in vars(spec.loader)
    monkeypatch.delitem(sys.modules, "hri_arm")


def test_numpy_may_be_imported_by_a_run() -> None:
    code = (
        "import sys\n"
        "from pytest_hricdv.runtime.random_numbers import seed_run\n"
        "assert 'numpy' not in sys.modules\n"
        "def run():\n"
        "    with seed_run(1):\n"
        "        import numpy\n"
        "        return numpy.random.rand(), numpy.random.default_rng().random()\n"
        "first = run()\n"
        "import numpy\n"
        "between = numpy.random.rand()\n"
        "print(first, run() == first, between)\n"
    )
    command = [sys.executable, "-c", code]
    said = [subprocess.check_output(command, cwd=ROOT, text=True).strip().rpartition(" ") for _ in range(2)]
    assert said[0][0].endswith("True")
    assert said[0][0] == said[1][0]
    assert said[0][2] != said[1][2], "after the run numpy is as it is without it: seeded by the system"


def test_identifiers_with_a_time_have_that_of_the_run() -> None:
    def made() -> list[uuid.UUID]:
        kernel, numbers = Kernel(), []

        def node() -> None:
            for _ in range(50):
                numbers.extend([clocks.uuid7(), clocks.uuid7()])
                kernel.sleep(0.01)

        kernel.spawn("node", node)
        kernel.run(limit_s=10.0)
        return numbers

    first = made()
    assert made() == first == sorted(first)
    assert {(number.version, number.variant) for number in first} == {(7, uuid.RFC_4122)}
    assert (first[-1].int >> 80) - (first[0].int >> 80) == 490, "milliseconds"
