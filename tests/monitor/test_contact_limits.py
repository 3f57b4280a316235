"""Contact limits by body region and the protective separation distance, beside cases computed by hand."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from pytest_hricdv.monitor import Log, RequirementError, Vocabulary, check_requirement, evaluate
from pytest_hricdv.monitor.build import requirement, signal
from pytest_hricdv.monitor.patterns import contact_limits, protective_separation

VOCABULARY = Vocabulary(signals={"region": str, "force": float, "pressure": float})
LIMITS = """
source = "an example, not limits to use"
transient_s = 0.5

[regions."hands and fingers"]
force_n = { transient = 60, quasi_static = 30 }
pressure_n_cm2 = { transient = 40, quasi_static = 20 }

[regions.chest]
force_n = { transient = 50, quasi_static = 25 }
"""
Steps = Sequence[tuple[float, float]]


def made(folder: Path, text: str = LIMITS) -> dict[str, str]:
    """Id -> formula."""
    (folder / "limits.toml").write_text(text)
    found = contact_limits(
        folder / "limits.toml", region=signal("region"), force=signal("force"), pressure=signal("pressure")
    )
    for each in found:
        check_requirement(each, VOCABULARY)
    return {each.id: each.text for each in found}


@pytest.mark.parametrize(
    ("region", "force", "pressure", "expected"),
    [
        # A hit of 0.4 s: below the transient limits, and not long enough to be quasi-static.
        ("hands and fingers", [(0, 0), (1, 55), (1.4, 0)], [(0, 0), (1, 35), (1.4, 0)], ("Passed", "Passed", "NC")),
        # The same for 0.6 s: at 1.5 s it is quasi-static, 55 N > 30 N; 15 N/cm2 are still allowed.
        ("hands and fingers", [(0, 0), (1, 55), (1.6, 0)], [(0, 0), (1, 15), (1.6, 0)], ("Failed", "Passed", "NC")),
        # Above the transient limit at once.
        ("hands and fingers", [(0, 0), (1, 61), (1.1, 0)], [(0, 0), (1, 41), (1.1, 0)], ("Failed", "Failed", "NC")),
        # Clamped below the quasi-static limits, for long.
        ("hands and fingers", [(0, 0), (1, 30)], [(0, 0), (1, 20)], ("Passed", "Passed", "NC")),
        # Limits are those of the region that is touched: 55 N are too much for the chest only.
        ("chest", [(0, 0), (1, 55), (1.2, 0)], [(0, 0)], ("NC", "NC", "Failed")),
        ("chest", [(0, 0), (1, 45), (1.2, 0)], [(0, 0)], ("NC", "NC", "Passed")),
        ("face", [(0, 0), (1, 55)], [(0, 0)], ("NC", "NC", "NC")),
    ],
)
def test_they_judge_as_computed_by_hand(
    region: str, force: Steps, pressure: Steps, expected: tuple[str, ...], tmp_path: Path
) -> None:
    (tmp_path / "limits.toml").write_text(LIMITS)
    found = contact_limits(
        tmp_path / "limits.toml", region=signal("region"), force=signal("force"), pressure=signal("pressure")
    )
    columns = {
        name: (tuple(t for t, _ in steps), tuple(float(v) for _, v in steps))
        for name, steps in (("force", force), ("pressure", pressure))
    }
    log = Log({"region": ((0.0,), (region,)), **columns}, (), 3.0)
    assert tuple(verdict.verdict for verdict in evaluate(found, log)) == expected


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("[regions.chest]", "[regions.chst]", "regions.chst: no such region; nearest: chest"),
        ("quasi_static = 25", "quasi_static = 75", r"regions.chest.force_n: expected 0 <= quasi_static <= transient"),
        ('source = "an example, not limits to use"', 'source = ""', "source: expected the source of the limits"),
        ("transient_s = 0.5", "transient_s = 0", "transient_s: expected more than 0 s"),
        ("transient_s = 0.5", "transient = 0.5", "unknown key 'transient'; nearest: transient_s"),
        ("transient = 50, ", "", "force_n"),
        ("[regions.chest]", "[regions.chest", "limits.toml:9:15: not TOML"),
    ],
)
def test_what_is_wrong_with_a_file_is_said(old: str, new: str, said: str, tmp_path: Path) -> None:
    assert old in LIMITS
    with pytest.raises(RequirementError, match=said) as error:
        made(tmp_path, LIMITS.replace(old, new))
    assert str(error.value).startswith(str(tmp_path / "limits.toml"))


def test_limits_of_what_is_not_simulated_are_refused(tmp_path: Path) -> None:
    (tmp_path / "limits.toml").write_text(LIMITS)
    with pytest.raises(RequirementError, match=r"hands and fingers\.pressure_n_cm2: the testbench has no such signal"):
        contact_limits(tmp_path / "limits.toml", region=signal("region"), force=signal("force"))
    with pytest.raises(RequirementError, match="no such file"):
        contact_limits(tmp_path / "limit.toml", region=signal("region"))


@pytest.mark.parametrize(
    ("speed", "distance_m", "verdict", "margin_m"),
    [
        # S_p = 1.6 * (0.1 + 0.3) + 0.5 * 0.1 + 0.075 + 0.2 + 0.05 + 0.01 = 1.025 m
        (0.5, 1.1, "Passed", 0.075),
        (0.5, 1.0, "Failed", -0.025),
        # S_p = 0.64 + 1.0 * 0.1 + 0.335 = 1.075 m: a faster robot needs more.
        (1.0, 1.1, "Passed", 0.025),
        (1.0, 1.05, "Failed", -0.025),
        # Standing still, it may be as near as it likes.
        (0.0, 0.01, "NC", None),
    ],
)
def test_the_protective_separation_distance_is_that_computed_by_hand(
    speed: float, distance_m: float, verdict: str, margin_m: float | None
) -> None:
    formula = protective_separation(
        signal("speed"), signal("distance"), v_h=1.6, t_r=0.1, t_s=0.3, v_r=signal("speed"), s_s=0.075, c=0.2,
        z_d=0.05, z_r=0.01,
    )  # fmt: skip
    log = Log({"speed": ((0.0,), (speed,)), "distance": ((0.0,), (distance_m,))}, (), 2.0)
    (found,) = evaluate([requirement("P", "Separation", formula)], log)
    assert found.verdict == verdict
    assert found.margin == (None if margin_m is None else pytest.approx(margin_m))
