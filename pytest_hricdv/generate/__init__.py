"""From belief subsets to tests: methods that generate abstract tests, and their concretization.

    beliefs                         the space of beliefs, and a file of subsets of it
    model, model_runner             the BDI agents: their declaration, and running them with one subset or with all
    qlearning, learner              what Q-learning is given; learning which beliefs cover many plans, and the policy
    saved_table                     a learned table in a file
    context                         what suites are generated from, and the protocol of methods
    methods                         the methods, and all of them by name
    abstract, suite_files           abstract tests as data, with their ids and seeds; files of them
    actors, causes                  the lanes of several actors, and the causal order between their actions
    sampler, concrete               declared ranges, and tests with parameters sampled from them
    chosen_values, schedule         parameters and decisions of the scheduler that a test fixes
    suite                           the generated suite, and its diagnosis
    rng                             random streams, seeds and digests

Nothing of these is imported here, so that a process that only replays a suite loads no BDI engine.
"""

from collections.abc import Iterator
from contextlib import contextmanager

from pytest_hricdv._base.message import InputError


class GenerateError(InputError):
    """A model, a belief space, a file of tests or a parameter that tests cannot be generated from.

    The message says what was expected, what was found and, if there is one, the place as `file:line:column`.
    """


@contextmanager
def name_place(where: str) -> Iterator[None]:
    """Within, a GenerateError gets the place where it is, before its text."""
    try:
        yield
    except GenerateError as error:
        raise GenerateError(f"{where}: {error}") from None
