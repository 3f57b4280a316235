"""What an optional part adds to the options of a session."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar, cast

from pytest_hricdv.registry import offers
from pytest_hricdv.session.option_kinds import Option
from pytest_hricdv.session.option_reader import OptionReader

if TYPE_CHECKING:
    from pytest_hricdv.testbench import Testbench

Settings = TypeVar("Settings")


class HasParts(Protocol):
    """Options of a session, with those of its parts."""

    @property
    def parts(self) -> Mapping[str, Any]:
        """Part -> its settings."""


class FeatureOptions(Generic[Settings]):
    """The options of a part; by default there are none.

    Attributes:
        name: of the part's folder.
        options: that it adds to pytest's.
        kinds: of thresholds that it adds to `--hri-fail-under`.
        suites: names of suites that it generates, given the others.
    """

    name = ""
    options: Sequence[Option] = ()
    kinds: tuple[str, ...] = ()
    suites: tuple[str, ...] = ()

    def read(self, reader: OptionReader) -> Settings | None:
        """Its settings; None where there are none. Raises pytest.UsageError for an invalid one."""
        return None

    def asks_for_suites(self, reader: OptionReader) -> bool:
        """Whether an option of it asks for its suites, which `--hri-suite` then need not name."""
        return False

    def settings(self, options: HasParts) -> Settings:
        """What `read` returned."""
        return cast("Settings", options.parts[self.name])

    def again(self, reader: OptionReader) -> Iterable[str]:
        """Options of the command line that decide which tests are generated and which fail."""
        return ()

    def configured(self, testbench: Testbench, options: HasParts) -> Testbench:
        """The testbench as its options have it. Raises TestbenchError where it cannot be that."""
        return testbench

    def fingerprint(self, options: HasParts) -> Mapping[str, str]:
        """Settings that results depend on, by option: a session that is resumed must have the same."""
        return {}


def suites_of_parts() -> frozenset[str]:
    """Names of all suites that parts generate."""
    return frozenset(name for part in part_options() for name in part.suites)


def part_options() -> tuple[FeatureOptions[Any], ...]:
    """Of all parts."""
    return offers("feature", "FEATURE")
