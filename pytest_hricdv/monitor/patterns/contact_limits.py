"""Contact limits by region of the body, from the user's own file: no figure of a standard is built in.

Testbenches call `contact_limits`, which makes the requirements; `contact_limits_template` gives a file to fill in. A
contact is transient for a moment and quasi-static afterwards, as when a hand is clamped. Each phase has limits of force
and pressure, by body region (power and force limiting, ISO 10218-2:2025; ISO/TS 15066:2016, 5.5.5 and annex A).
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path

from pytest_hricdv._base.input_file import read_toml
from pytest_hricdv._base.message import InputError, nearest
from pytest_hricdv._base.record import PlainRecord
from pytest_hricdv.monitor.build import always, equal, requirement
from pytest_hricdv.monitor.dsl import NameValue, NumberValue, TextValue
from pytest_hricdv.monitor.requirement import Requirement, RequirementError

BODY_REGIONS = (
    "skull and forehead",
    "face",
    "neck",
    "back and shoulders",
    "chest",
    "abdomen",
    "pelvis",
    "upper arms and elbow joints",
    "lower arms and wrist joints",
    "hands and fingers",
    "thighs and knees",
    "lower legs",
)
"""The regions of ISO/TS 15066:2016, annex A."""


class ContactLimit(PlainRecord, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The limits of a quantity, for transient and quasi-static contact."""

    transient: float
    quasi_static: float


class RegionLimits(PlainRecord, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The limits of a region: force (N) and pressure (N/cm2)."""

    force_n: ContactLimit | None = None
    pressure_n_cm2: ContactLimit | None = None


class ContactLimits(PlainRecord, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A file of limits.

    Attributes:
        source: the source of the limits.
        transient_s: a contact that lasts longer (s) is quasi-static.
        regions: region -> its limits.
    """

    source: str
    transient_s: float
    regions: Mapping[str, RegionLimits]


def contact_limits(
    path: Path, *, region: TextValue | NameValue, force: NumberValue | None = None, pressure: NumberValue | None = None
) -> tuple[Requirement, ...]:
    """A requirement for each region and quantity that a file has limits for.

    Formula, of a force: `always(region == "chest" & force > 0 -> force <= transient & !(force > quasi_static [for
    transient_s]))`. Scope: while the region is touched.

    Args:
        path: the file's path, as from `contact_limits_template`.
        region: the touched region, a text.
        force: the force of the contact (N), not negative; None if it is not simulated.
        pressure: the pressure of the contact (N/cm2), likewise.

    Raises:
        RequirementError: located, if the file has no limits, an unknown region, or limits of a quantity that is not
            simulated.
    """
    limits = _read(path)
    return tuple(_requirements(path, limits, region, {"force_n": force, "pressure_n_cm2": pressure}))


def _read(path: Path) -> ContactLimits:
    try:
        limits = read_toml(path, ContactLimits)
    except InputError as error:
        raise RequirementError(f"{error}; contact_limits_template() begins such a file") from None
    if not limits.source:
        raise RequirementError(f"{path}: source: expected the source of the limits, such as a risk assessment")
    if limits.transient_s <= 0:
        raise RequirementError(f"{path}: transient_s: expected more than 0 s, got {limits.transient_s:g}")
    if not limits.regions:
        raise RequirementError(f"{path}: regions: expected limits of at least one region")
    return limits


def _requirements(
    path: Path, limits: ContactLimits, region: TextValue | NameValue, quantities: Mapping[str, NumberValue | None]
) -> Iterator[Requirement]:
    for name, of_region in limits.regions.items():
        if name not in BODY_REGIONS:
            raise RequirementError(f"{path}: regions.{name}: no such region{nearest(name, BODY_REGIONS)}")
        for key, value in quantities.items():
            limit: ContactLimit | None = getattr(of_region, key)
            if limit is None:
                continue
            place = f"{path}: regions.{name}.{key}"
            if value is None:
                raise RequirementError(f"{place}: the testbench has no such signal of a contact")
            if not 0 <= limit.quasi_static <= limit.transient:
                raise RequirementError(f"{place}: expected 0 <= quasi_static <= transient")
            word, unit = ("force", "N") if key == "force_n" else ("pressure", "N/cm2")
            within = (value <= limit.transient) & ~(value > limit.quasi_static).held_for(limits.transient_s)
            yield requirement(
                f"CONTACT-{re.sub('[^a-z]+', '-', name)}-{word}",
                f"{name}: {word} at most {limit.transient:g} {unit}, and {limit.quasi_static:g} {unit} if it lasts",
                always((equal(region, name) & (value > 0)) >> within),
                source=limits.source,
            )


def contact_limits_template() -> str:
    """A file of limits without figures, to be filled in."""
    lines = [
        "# Limits of contact by body region. The figures are those of your risk assessment.",
        'source = ""          # such as "Risk assessment of cell 4, table 3"',
        "transient_s = 0.0    # a contact that lasts longer is quasi-static: clamped",
        "",
        "[regions]            # uncomment regions that can be touched; a quantity without limits is not checked",
    ]
    for name in BODY_REGIONS:
        lines += ["", f'# [regions."{name}"]']
        lines += [f"# {key} = {{ transient = , quasi_static = }}" for key in ("force_n", "pressure_n_cm2")]
    return "\n".join(lines) + "\n"
