"""What ends a test is no verdict of the code under test."""

from __future__ import annotations

import os
import unittest
from collections.abc import Callable

import pytest

from pytest_hricdv.runtime import Kernel, NodeError
from pytest_hricdv.runtime.node_error import refusal, word_of
from pytest_hricdv.runtime.virtual.outside import guard_run


class Busy(unittest.SkipTest):
    """A subclass, as libraries have."""


WORDS = {
    "pytest.skip": pytest.skip.Exception("no sensor"),
    "pytest.xfail": pytest.xfail.Exception("no sensor"),
    "pytest.exit": pytest.exit.Exception("no sensor"),
    "unittest.SkipTest": Busy("no sensor"),
}


@pytest.mark.parametrize("word", WORDS)
def test_a_node_that_ends_the_test_by_a_word_of_pytest_has_failed(word: str) -> None:
    kernel = Kernel()

    def node() -> None:
        kernel.sleep(1.0)
        raise WORDS[word]

    kernel.spawn("robot", node)
    with pytest.raises(NodeError, match=r"robot failed at 1\.000 s: .*no sensor") as raised:
        kernel.run(10.0)
    assert word_of(raised.value.__cause__) == word


@pytest.mark.parametrize("word", WORDS)
def test_a_node_that_does_so_while_the_run_closes_has_failed(word: str) -> None:
    kernel = Kernel()

    def node() -> None:
        try:
            kernel.sleep(100.0)
        finally:
            raise WORDS[word]

    kernel.spawn("robot", node)
    kernel.run(1.0)
    with pytest.raises(type(WORDS[word])):
        kernel.close()


def test_the_refusal_says_where_and_what_to_do() -> None:
    try:
        pytest.skip("no sensor")
    except pytest.skip.Exception as error:
        text = refusal(error)
    assert text.startswith(f"{__file__}:")
    assert ": pytest.skip('no sensor') in a run: only a test function or a fixture may" in text


def test_a_run_does_not_end_the_process() -> None:
    kernel = Kernel()
    kernel.spawn("robot", lambda: os._exit(0))
    with (
        guard_run(kernel),
        pytest.raises(NodeError, match=r"os\._exit\(0\) at .*test_termination\.py:\d+: it would end"),
    ):
        kernel.run(1.0)


@pytest.mark.parametrize(("end", "status"), [(lambda: os._exit(7), 7), (lambda: None, 1)])
def test_a_process_that_a_node_has_forked_ends_as_it_likes_or_with_the_run(
    end: Callable[[], object], status: int
) -> None:
    kernel, children = Kernel(), list[int]()

    def node() -> None:
        child = os.fork()
        if child == 0:
            end()
        children.append(child)

    kernel.spawn("robot", node)
    with guard_run(kernel), kernel.supervision.watch():
        kernel.run(1.0)
    assert os.waitstatus_to_exitcode(os.waitpid(children[0], 0)[1]) == status


@pytest.mark.parametrize("replace", [lambda: os.execv("/bin/true", ["true"]), lambda: os.execlp("true", "true")])
def test_a_run_does_not_become_another_program(replace: Callable[[], None]) -> None:
    kernel = Kernel()
    kernel.spawn("robot", replace)
    with guard_run(kernel), pytest.raises(NodeError, match=r"os\.execve?\(.* at .*test_termination\.py:\d+: it would"):
        kernel.run(1.0)
