"""The text of an error of somebody else's code, in a line: with what it stands for, and whatever its `__str__` does."""

from __future__ import annotations

from collections.abc import Iterator

MAX_LEAVES = 4
"""Of a group of errors (chosen): a line of a terminal."""

MAX_CAUSES = 3
"""Of a chain of causes (chosen): the last one and what led to it; the traceback has all."""


def error_text(error: BaseException) -> str:
    """`ExceptionGroup: unhandled errors in a TaskGroup (2 sub-exceptions): ValueError: no dimmer; OSError: no bulb`.

    Causes follow: `RuntimeError: cannot serve, from KeyError: 'rig'`.
    """
    texts: list[str] = []
    cause: BaseException | None = error
    while cause is not None and len(texts) < MAX_CAUSES:
        texts.append(_alone(cause))
        hidden = cause.__suppress_context__
        cause = cause.__cause__ or (None if hidden else cause.__context__)
    return ", from ".join(texts)


def _alone(error: BaseException) -> str:
    try:
        message = str(error)
    except Exception as failure:  # of the author's own __str__
        message = f"(its text raised {type(failure).__name__})"
    text = " ".join(f"{type(error).__name__}: {message}".removesuffix(": ").split())
    if not isinstance(error, BaseExceptionGroup):
        return text
    leaves = [*_leaves(error)]
    named = [_alone(leaf) for leaf in leaves[:MAX_LEAVES]]
    more = [f"and {len(leaves) - MAX_LEAVES} more"] if len(leaves) > MAX_LEAVES else []
    return f"{text}: {'; '.join([*named, *more])}"


def _leaves(group: BaseExceptionGroup[BaseException]) -> Iterator[BaseException]:
    for error in group.exceptions:
        if isinstance(error, BaseExceptionGroup):
            yield from _leaves(error)
        else:
            yield error
