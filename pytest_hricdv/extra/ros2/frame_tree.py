"""`FrameTree` of tf2: keeps the transforms of each frame, and looks transforms up along the tree.

`BufferCore` in `tf2`, which replaces `tf2_py`, has one `FrameTree`. Error messages and the classes of errors are those
of tf2's `BufferCore`. Times are in nanoseconds; 0 means the latest common time.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from pytest_hricdv.extra.ros2.transforms import (
    MovingFrame,
    NoTransformError,
    StampedTransform,
    StaticFrame,
    Transform,
    seconds,
)

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

_GRAPH_DEPTH = 1000
"""tf2's `MAX_GRAPH_DEPTH`: a longer chain of frames is a loop."""


class TransformException(Exception):  # noqa: N818 (the names are tf2's)
    """tf2's base class of errors."""


class ConnectivityException(TransformException):
    """tf2: the frames are in trees that are not connected."""


class LookupException(TransformException):
    """tf2: there is no such frame."""


class ExtrapolationException(TransformException):
    """tf2: there is no data for this time."""


class InvalidArgumentException(TransformException):
    """tf2: the name of a frame is invalid."""


class TimeoutException(TransformException):
    """tf2: no transform arrived in time."""


EXCEPTIONS = (
    TransformException,
    ConnectivityException,
    LookupException,
    ExtrapolationException,
    InvalidArgumentException,
    TimeoutException,
)


class FrameTree:
    """Frames by name, each with the transforms to its parent, which are kept for `keeps_ns`."""

    def __init__(self, keeps_ns: int) -> None:
        self._keeps_ns = keeps_ns
        self._frames: dict[str, StaticFrame | MovingFrame | None] = {}
        """Name -> its transforms, None for a root; in the order in which the names first occurred."""
        self._authorities: dict[str, str] = {}

    @property
    def names(self) -> list[str]:
        """The names of all frames, in the order in which they first occurred."""
        return list(self._frames)

    def clear(self) -> None:
        """Remove all transforms but static ones; the names of frames remain."""
        for frame in self._frames.values():
            if frame is not None:
                frame.clear()

    def insert(self, child: str, stored: StampedTransform, authority: str, *, is_static: bool) -> bool:
        """Add a transform of a frame. Returns False if it is too old to be kept."""
        frame = self._frames.get(child)
        if frame is None or frame.is_static != is_static:
            frame = self._frames[child] = StaticFrame() if is_static else MovingFrame(self._keeps_ns)
        self._frames.setdefault(stored.parent, None)
        if not frame.insert(stored):
            return False
        self._authorities[child] = authority
        return True

    def can_transform(self, target: str, source: str, time_ns: int) -> tuple[int, str]:
        """Whether there is a transform, as 1 or 0, and the reason if not."""
        try:
            self._walk(target, source, time_ns)
        except TransformException as error:
            return 0, str(error)
        return 1, ""

    def name_problem(self, frame: str, where: str) -> str:
        """The message about an invalid or unknown frame name; empty if the frame exists."""
        rationale = _name_fault(frame) or ("" if frame in self._frames else "frame does not exist")
        return f'Invalid frame ID "{frame}" passed to {where} - {rationale}' if rationale else ""

    def require(self, frame: str, where: str) -> None:
        """Check that a frame exists. Raises InvalidArgumentException or LookupException."""
        if rationale := _name_fault(frame):
            raise InvalidArgumentException(f'Invalid argument "{frame}" passed to {where} - {rationale}')
        if frame not in self._frames:
            raise LookupException(f'"{frame}" passed to {where} does not exist. ')

    def lookup(self, target: str, source: str, time_ns: int) -> tuple[Transform, int]:
        """The transform from the source to the target frame, and its time.

        Raises:
            LookupException: there is no such frame.
            ConnectivityException: no chain of frames connects them.
            ExtrapolationException: the time is not between those of the transforms.
            InvalidArgumentException: a frame without a name, or with a slash before it.
        """
        if target == source:
            frame = self._frames.get(target)
            return Transform(), frame.latest_ns if frame is not None and time_ns == 0 else time_ns
        self.require(target, "lookupTransform argument target_frame")
        self.require(source, "lookupTransform argument source_frame")
        return self._walk(target, source, time_ns)

    def _walk(self, target: str, source: str, time_ns: int) -> tuple[Transform, int]:
        """The transform along the tree, and its time. Raises the same errors as `lookup`."""
        if target == source:
            return Transform(), time_ns
        if time_ns == 0:
            time_ns = self.common_ns(target, source)
        ending = f", when looking up transform from frame [{source}] to frame [{target}]"
        up, missing = self._climb(source, target, time_ns)
        if target in up:
            return up[target], time_ns
        frame, down, depth = target, Transform(), 0
        while frame not in up and (history := self._frames[frame]) is not None:
            try:
                stored = history.at(time_ns)
            except NoTransformError as error:
                raise ExtrapolationException(f"{error}{ending}") from None
            down, frame, depth = stored.after(down), stored.parent, depth + 1
            self._check_depth(depth)
        if frame in up:
            return down.inverse().after(up[frame]), time_ns
        if missing is not None:
            raise ExtrapolationException(f"{missing}{ending}")
        raise ConnectivityException(_no_connection_text(source, target))

    def _climb(self, source: str, target: str, time_ns: int) -> tuple[dict[str, Transform], NoTransformError | None]:
        """The transforms from the source to the frames above it, up to the target; and the error that stopped it."""
        up = {source: Transform()}
        frame, depth = source, 0
        while frame != target and (history := self._frames[frame]) is not None:
            try:
                stored = history.at(time_ns)
            except NoTransformError as error:
                return up, error  # the target may still be below one of these frames
            up[stored.parent] = stored.after(up[frame])
            frame, depth = stored.parent, depth + 1
            self._check_depth(depth)
        return up, None

    def _check_depth(self, depth: int) -> None:
        if depth > _GRAPH_DEPTH:
            raise LookupException(
                f"The tf tree is invalid because it contains a loop.\n{self.all_frames_as_string()}\n"
            )

    def common_ns(self, target: str, source: str) -> int:
        """The latest time at which all transforms between two frames are known; 0 if all are static."""
        if source == target:
            frame = self._frames[source]
            return 0 if frame is None else frame.latest_ns
        chain = dict(self._latest_upwards(source, target))
        if target in chain:
            return _earliest(chain.values())
        times: list[int] = []
        for parent, latest_ns in self._latest_upwards(target, source):
            times.append(latest_ns)
            if parent == source:
                return _earliest(times)
            if parent in chain:
                upwards = list(chain)
                return _earliest([*times, *list(chain.values())[: upwards.index(parent) + 1]])
        raise ConnectivityException(_no_connection_text(source, target))

    def _latest_upwards(self, frame: str, end: str) -> Iterator[tuple[str, int]]:
        """The parents of a frame up to `end` or the root, each with the latest time of the transform to it (ns)."""
        for depth in range(_GRAPH_DEPTH + 2):
            self._check_depth(depth)
            history = self._frames[frame]
            if history is None or not history.parent:
                return
            latest_ns = history.latest_ns
            frame = history.parent
            yield frame, latest_ns
            if frame == end:
                return

    def all_frames_as_string(self) -> str:
        """A line for each frame that has a parent."""
        parents = [(name, frame.parent) for name, frame in self._frames.items() if frame is not None]
        return "".join(f"Frame {name} exists with parent {parent or 'NO_PARENT'}.\n" for name, parent in parents)

    def all_frames_as_yaml(self) -> str:
        """The frames that have a parent, with rate and times of their transforms, as YAML."""
        text = "" if self._frames else "[]"
        for name, frame in self._frames.items():
            if frame is None or not frame.parent:
                continue
            length_ns = frame.latest_ns - frame.oldest_ns
            rate_hz = len(frame) * 1e9 / max(length_ns, 100_000)
            text += (
                f"{name}: \n  parent: '{frame.parent}'\n"
                f"  broadcaster: '{self._authorities.get(name, 'no recorded authority')}'\n  rate: {rate_hz:.3f}\n"
                f"  most_recent_transform: {seconds(frame.latest_ns)}\n"
                f"  oldest_transform: {seconds(frame.oldest_ns)}\n  buffer_length: {length_ns / 1e9:.3f}\n"
            )
        return text


def _name_fault(frame: str) -> str:
    if not frame:
        return "in tf2 frame_ids cannot be empty"
    return "in tf2 frame_ids cannot start with a '/'" if frame.startswith("/") else ""


def _no_connection_text(source: str, target: str) -> str:
    # The words, the missing space and the order of the frames are tf2's.
    return (
        f"Could not find a connection between '{target}' and '{source}' because they are not part of the same tree."
        "Tf has two or more unconnected trees."
    )


def _earliest(times_ns: Iterable[int]) -> int:
    """The earliest time, without those of static transforms (0); 0 if all are static."""
    return min((time_ns for time_ns in times_ns if time_ns), default=0)
