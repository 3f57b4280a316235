"""Random numbers in a run (`seed_run`): unseeded generators are seeded from the test.

`execution.case` executes each run within `seed_run`. It seeds Python's and numpy's global generators, and what unseeded
generators take their seeds from:
`os.urandom` (`secrets`, `uuid4`, `SystemRandom`, names of temporary files, `numpy.random.default_rng()`) and
`random.Random()`. Unlike virtual time, this also applies to testbench and world, which have to repeat as well. When the
run is over, however it ends, all generators are as they were before.
"""

from __future__ import annotations

import os
import random
import sys
import tempfile
import threading
import uuid
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any, cast

from pytest_hricdv.runtime.redirection import Redirection, original

_urandom = original(os.urandom)
_getrandom = original(getattr(os, "getrandom", None))  # Linux only
_SEED, _seed_global = random.Random.seed, random.seed
_seed = original(_SEED)


class _Entropy:
    """A run's replacement for the entropy of the operating system: a stream for itself, and one for each new thread.

    Args:
        key: the streams are those of this text.
    """

    def __init__(self, key: str) -> None:
        self.key = key
        self._stream = random.Random(key)
        self._thread = threading.get_ident()
        # As objects: a thread may get the identity of an ended one.
        self._of_others = set(threading.enumerate()) - {threading.current_thread()}
        self._of_threads: dict[threading.Thread, random.Random] = {}

    @property
    def is_of_this_thread(self) -> bool:
        """Whether this thread is the one that the run began in."""
        return threading.get_ident() == self._thread

    def of_this_thread(self) -> random.Random | None:
        """None for a thread outside the run: threads of xdist, for instance, have real entropy."""
        if self.is_of_this_thread:
            return self._stream
        thread = threading.current_thread()
        if thread in self._of_others:
            return None
        if thread not in self._of_threads:
            self._of_threads[thread] = random.Random(f"{self.key}, thread {len(self._of_threads)}")
        return self._of_threads[thread]


_IMPORT = "import of "

_entropy: _Entropy | None = None
"""The entropy of the current run in this process."""


def _stream() -> random.Random | None:
    return _entropy.of_this_thread() if _entropy is not None else None


def urandom(size: int, /) -> bytes:
    """Like that of `os`."""
    stream = _stream()
    return _urandom(size) if stream is None else stream.randbytes(size)


def getrandom(size: int, flags: int = 0) -> bytes:
    """Like that of `os`."""
    stream = _stream()
    return _getrandom(size, flags) if stream is None else stream.randbytes(size)


def _seed_generator(generator: random.Random, a: Any = None, version: int = 2) -> None:
    """As the method `seed` of `random.Random`: Python's own takes what it needs from the system, in C."""
    stream = _stream() if a is None else None
    _seed(generator, a if stream is None else stream.getrandbits(256), version)


def _without_time(name: str) -> Callable[..., uuid.UUID]:
    """As a function of `uuid` that takes the time; in a run it names no machine and no time, but is one of `uuid4`."""
    real = original(getattr(uuid, name))

    def call(*arguments: Any, **named: Any) -> uuid.UUID:
        return cast(uuid.UUID, real(*arguments, **named)) if _stream() is None else uuid.uuid4()

    return call


_UNTIMED = [
    (getattr(uuid, name), _without_time(name))
    for name in ("uuid1", "uuid6", "uuid7")
    if hasattr(uuid, name)  # from 3.14 on
]


_REDIRECTION = Redirection(
    [
        (os.urandom, urandom),
        *([(os.getrandom, getrandom)] if hasattr(os, "getrandom") else []),
        (_SEED, _seed_generator),
        *_UNTIMED,
    ]
)


class _Generators:
    """Python's global generator as it was at one time, and numpy's, unless it is left alone."""

    def __init__(self, *, with_numpy: bool) -> None:
        self._python = random.getstate()
        self._with_numpy = with_numpy
        numpy_random = _numpy_random() if with_numpy else None
        self._numpy = None if numpy_random is None else numpy_random.get_state(legacy=False)
        self._bits = None if numpy_random is None else _bit_generator(numpy_random)

    def put_back(self, key: str | None) -> None:
        """Let them be as they were; numpy's, if it is new, is that of a key, or of the system where this is None."""
        random.setstate(self._python)
        numpy_random = _numpy_random() if self._with_numpy else None
        if numpy_random is None:
            return
        if self._numpy is None:
            _seed_numpy(numpy_random, key)
            return
        if _bit_generator(numpy_random) is not self._bits:  # somebody has chosen another one in the meantime
            numpy_random.set_bit_generator(self._bits)
        numpy_random.set_state(self._numpy)


def _numpy_random() -> Any:
    """`numpy.random`, if it has been imported."""
    # Restoring `sys.modules`, as tests of plugins do, leaves it in numpy, which gets it only once it is imported.
    module = sys.modules.get("numpy.random") or getattr(sys.modules.get("numpy"), "__dict__", {}).get("random")
    return module if hasattr(module, "set_state") else None  # not while it is being imported


def _bit_generator(numpy_random: Any) -> Any:
    return numpy_random.mtrand._rand._bit_generator  # numpy has a function for it since 1.24


def _seed_numpy(numpy_random: Any, key: str | None) -> None:
    number = None if key is None else random.Random(key).getrandbits(32)  # as many bits as its old seed may have
    bits = _bit_generator(numpy_random)
    if type(bits).__name__ == "MT19937":
        numpy_random.seed(number)
    else:  # its `seed` refuses any other one
        bits.state = type(bits)(number).state


@contextmanager
def _draw_from(key: str, *, with_numpy: bool = True) -> Iterator[None]:
    """Within, everything that is random is that of a key; afterwards it is as before."""
    global _entropy
    before, generators = _entropy, _Generators(with_numpy=with_numpy)
    try:
        _entropy = _Entropy(key)
        _seed_global(key)
        numpy_random = _numpy_random() if with_numpy else None
        if numpy_random is not None:
            _seed_numpy(numpy_random, key)
        yield
    finally:
        _entropy = before
        generators.put_back(None if before is None else before.key)


@contextmanager
def spare_run() -> Iterator[None]:
    """Within, this process draws from the system: what the plugin itself draws is not missing in a run's streams."""
    global _entropy
    before, _entropy = _entropy, None
    try:
        yield
    finally:
        _entropy = before


class _ImportsApart(MetaPathFinder):
    """Lets a module draw from streams of its own while it is imported.

    This happens once in a process: what it drew from the run's streams would be missing there in this run, and in no
    other one.
    """

    def __init__(self) -> None:
        self._loaders: list[Any] = []
        self._searched: set[str] = set()

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None, /
    ) -> ModuleSpec | None:
        """The spec of the other finders, with a loader that executes the module so."""
        if fullname in self._searched:
            return None  # another finder, which asks all others as this one does, has asked this one
        self._searched.add(fullname)
        try:
            spec = _first_spec(fullname, path, target)
        finally:
            self._searched.discard(fullname)
        loader: Any = None if spec is None else spec.loader
        # A loader that has it in itself is the class that loads built-in modules, or one that is dealt with.
        if hasattr(loader, "exec_module") and "exec_module" not in getattr(loader, "__dict__", ("exec_module",)):
            vars(loader)["exec_module"] = partial(_execute, loader.exec_module)
            self._loaders.append(loader)
        return spec

    def release(self) -> None:
        """Loaders are again what they were."""
        for loader in self._loaders:
            vars(loader).pop("exec_module", None)


def _first_spec(fullname: str, path: Sequence[str] | None, target: ModuleType | None) -> ModuleSpec | None:
    others = [finder for finder in sys.meta_path if not isinstance(finder, _ImportsApart)]
    specs = (finder.find_spec(fullname, path, target) for finder in others if hasattr(finder, "find_spec"))
    return next((spec for spec in specs if spec is not None), None)


def _execute(execute: Callable[[ModuleType], None], module: ModuleType) -> None:
    if _entropy is None or not _entropy.is_of_this_thread:
        execute(module)
        return
    # Saving the state of numpy's generator takes longer than all else here, so it is done once for a module and its
    # imports.
    with _draw_from(f"{_IMPORT}{module.__name__}", with_numpy=not _entropy.key.startswith(_IMPORT)):
        execute(module)


@contextmanager
def seed_run(test_seed: int) -> Iterator[None]:
    """A run: within, everything that is random depends on the test's seed only."""
    with suppress(OSError):
        tempfile.gettempdir()  # what it draws to find it, it draws once in a process
    finder = _ImportsApart()
    names: Any = tempfile  # the sequence of names has a generator of its own for as long as the process lives
    sequence = names._name_sequence
    seed_before = random.Random.seed
    with _draw_from(f"hricdv {test_seed}"):
        _REDIRECTION.install()
        random.Random.seed = _SEED  # type: ignore[method-assign]  # the audit may watch it
        names._name_sequence = None
        sys.meta_path.insert(0, finder)
        try:
            yield
        finally:
            if finder in sys.meta_path:
                sys.meta_path.remove(finder)
            finder.release()
            names._name_sequence = sequence
            random.Random.seed = seed_before  # type: ignore[method-assign]
            _REDIRECTION.remove()


_before_fork: list[object] = []


def _prepare_fork() -> None:
    _before_fork[:] = [random.getstate()] if _entropy is not None else []


def _restore_after_fork() -> None:
    """Python's own `random` has just drawn a new seed: a fork within a run continues as its parent would."""
    if _before_fork:
        random.setstate(_before_fork.pop())  # type: ignore[arg-type]


if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_prepare_fork, after_in_child=_restore_after_fork, after_in_parent=_before_fork.clear)
