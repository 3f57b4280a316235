"""Quality of service: profiles, and which publishers and subscriptions match (DDS 1.4, 2.2.3).

`topics` and `services` give each endpoint a `Profile`, which `effective` completes with defaults. `mismatches` says
which policies keep a subscription from matching a publisher; `check_compatible` tells `rclpy` the same.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum
from functools import cache
from typing import Any

from pytest_hricdv.extra.ros2.clocks import Duration
from pytest_hricdv.extra.ros2.messages import NS_PER_S

# As in rmw (ns): an infinite duration, and the duration that means "as the other endpoint's".
INFINITE_NS = 2**63 - 1
BEST_AVAILABLE_NS = INFINITE_NS - 1


class QosPolicyKind(IntEnum):
    """The kinds of QoS policies, numbered like `rmw_qos_policy_kind_t`."""

    RMW_QOS_POLICY_INVALID = 1
    RMW_QOS_POLICY_DURABILITY = 2
    RMW_QOS_POLICY_DEADLINE = 4
    RMW_QOS_POLICY_LIVELINESS = 8
    RMW_QOS_POLICY_RELIABILITY = 16
    RMW_QOS_POLICY_HISTORY = 32
    RMW_QOS_POLICY_LIFESPAN = 64
    RMW_QOS_POLICY_DEPTH = 128
    RMW_QOS_POLICY_LIVELINESS_LEASE_DURATION = 256
    RMW_QOS_POLICY_AVOID_ROS_NAMESPACE_CONVENTIONS = 512


# The values of policies in rmw/types.h; 0 leaves a policy to the system.
KEEP_LAST, KEEP_ALL = 1, 2
RELIABLE, BEST_EFFORT = 1, 2
TRANSIENT_LOCAL, VOLATILE = 1, 2
AUTOMATIC, MANUAL_BY_TOPIC = 1, 3
_UNKNOWN_LIVELINESS, _BEST_LIVELINESS = 4, 5
_SYSTEM_DEFAULT, _UNKNOWN, _BEST_AVAILABLE = 0, 3, 4


class QoSCompatibility(IntEnum):
    """Whether two profiles match, numbered like `rmw_qos_compatibility_type_t`."""

    OK = 0
    WARNING = 1
    ERROR = 2


@dataclass(frozen=True)
class CompatibilityResult:
    """Whether two profiles match, and why not, like `QoSCheckCompatibleResult` of `rclpy`."""

    compatibility: QoSCompatibility = QoSCompatibility.OK
    reason: str = ""


@dataclass(frozen=True)
class Profile:
    """The QoS policies of an endpoint, as numbers of rmw; durations in ns, where 0 means unspecified."""

    history: int = KEEP_LAST
    depth: int = 10
    reliability: int = RELIABLE
    durability: int = VOLATILE
    lifespan_ns: int = 0
    deadline_ns: int = 0
    liveliness: int = _SYSTEM_DEFAULT
    lease_ns: int = 0
    avoid_conventions: bool = False

    @property
    def queue_length(self) -> int | None:
        """The number of messages that a queue keeps; None: all."""
        # A depth of 0 is the system's default, which is one message at least.
        return None if self.history == KEEP_ALL else max(self.depth, 1)

    @property
    def is_transient_local(self) -> bool:
        """Whether a publisher keeps messages for later subscriptions."""
        return self.durability == TRANSIENT_LOCAL

    @property
    def finite_deadline_ns(self) -> int:
        """The deadline (ns); 0: none."""
        return self.deadline_ns if self.deadline_ns < BEST_AVAILABLE_NS else 0

    @property
    def finite_lifespan_ns(self) -> int:
        """The lifespan of a message (ns); 0: for ever."""
        return self.lifespan_ns if self.lifespan_ns < BEST_AVAILABLE_NS else 0

    @property
    def finite_lease_ns(self) -> int:
        """The lease of the liveliness (ns); 0: for ever."""
        return self.lease_ns if self.lease_ns < BEST_AVAILABLE_NS else 0

    def to_dict(self) -> dict[str, Any]:
        """The arguments of `rclpy.qos.QoSProfile`."""
        from rclpy.duration import Duration as RclpyDuration  # type: ignore[import-not-found, unused-ignore]

        return {
            "depth": self.depth,
            "history": self.history,
            "reliability": self.reliability,
            "durability": self.durability,
            "lifespan": RclpyDuration(nanoseconds=self.lifespan_ns),
            "deadline": RclpyDuration(nanoseconds=self.deadline_ns),
            "liveliness": self.liveliness,
            "liveliness_lease_duration": RclpyDuration(nanoseconds=self.lease_ns),
            "avoid_ros_namespace_conventions": self.avoid_conventions,
        }


_UNKNOWN_PROFILE = Profile(_UNKNOWN, 0, _UNKNOWN, _UNKNOWN, liveliness=_UNKNOWN_LIVELINESS)

PREDEFINED = {
    "qos_profile_default": Profile(),
    "qos_profile_sensor_data": Profile(depth=5, reliability=BEST_EFFORT),
    "qos_profile_services_default": Profile(),
    "qos_profile_parameters": Profile(depth=1000),
    "qos_profile_parameter_events": Profile(depth=1000),
    # Late joiners get the last ten seconds of the log, up to a thousand entries.
    "qos_profile_rosout_default": Profile(depth=1000, durability=TRANSIENT_LOCAL, lifespan_ns=10 * NS_PER_S),
    "qos_profile_system_default": Profile(_SYSTEM_DEFAULT, 0, _SYSTEM_DEFAULT, _SYSTEM_DEFAULT),
    "qos_profile_unknown": _UNKNOWN_PROFILE,
    "qos_profile_best_available": Profile(
        reliability=_BEST_AVAILABLE,
        durability=_BEST_AVAILABLE,
        deadline_ns=BEST_AVAILABLE_NS,
        liveliness=_BEST_LIVELINESS,
        lease_ns=BEST_AVAILABLE_NS,
    ),
}
"""Name -> profile, with the values of rmw's `qos_profiles.h`."""

ACTION_STATUS = Profile(depth=1, durability=TRANSIENT_LOCAL)
"""The profile of an action's status topic."""


def _profile_named(name: str) -> Profile:
    """A profile of rmw. Raises ValueError for an unknown name."""
    if name not in PREDEFINED:
        raise ValueError(f"Requested unknown rmw_qos_profile: {name}")
    return PREDEFINED[name]


class RmwProfile(Profile):
    """Like `rmw_qos_profile_t`: `rclpy` makes it of numbers and durations."""

    def __init__(
        self,
        history: int,
        depth: int,
        reliability: int,
        durability: int,
        lifespan: Duration,
        deadline: Duration,
        liveliness: int,
        lease: Duration,
        avoid_conventions: bool,
    ) -> None:
        policies = int(history), depth, int(reliability), int(durability)
        durations = lifespan.nanoseconds, deadline.nanoseconds
        super().__init__(*policies, *durations, int(liveliness), lease.nanoseconds, avoid_conventions)

    predefined = staticmethod(_profile_named)


def effective(profile: Profile, *, receives: bool = False) -> Profile:
    """The profile with system defaults resolved as in Fast DDS: keep last, automatic liveliness.

    Publishers are reliable, and keep messages for later ones; subscriptions (`receives`) want neither.
    """
    reliability, durability = (BEST_EFFORT, VOLATILE) if receives else (RELIABLE, TRANSIENT_LOCAL)
    return replace(
        Profile(**vars(profile)),
        history=KEEP_LAST if profile.history == _SYSTEM_DEFAULT else profile.history,
        reliability=reliability if profile.reliability == _SYSTEM_DEFAULT else profile.reliability,
        durability=durability if profile.durability == _SYSTEM_DEFAULT else profile.durability,
        liveliness=AUTOMATIC if profile.liveliness == _SYSTEM_DEFAULT else profile.liveliness,
    )


_POLICY_TEXTS: dict[QosPolicyKind, tuple[str, str, dict[int, str]]] = {
    QosPolicyKind.RMW_QOS_POLICY_RELIABILITY: (
        "reliability", "reliability", {RELIABLE: "reliable", BEST_EFFORT: "best effort"}
    ),
    QosPolicyKind.RMW_QOS_POLICY_DURABILITY: (
        "durability", "durability", {TRANSIENT_LOCAL: "transient local", VOLATILE: "volatile"}
    ),
    QosPolicyKind.RMW_QOS_POLICY_DEADLINE: ("deadline", "deadline_ns", {}),
    QosPolicyKind.RMW_QOS_POLICY_LIVELINESS: (
        "liveliness", "liveliness", {AUTOMATIC: "automatic", MANUAL_BY_TOPIC: "manual by topic"}
    ),
    QosPolicyKind.RMW_QOS_POLICY_LIVELINESS_LEASE_DURATION: ("lease of the liveliness", "lease_ns", {}),
}  # fmt: skip
"""Policy -> its name in reports, its attribute of a profile, and names of its values; durations have none."""


def policies_text(offered: Profile, requested: Profile) -> str:
    """The mismatched policies of two profiles, for a report: "durability: volatile is offered, ..."."""
    parts = []
    for policy, _ in mismatches(offered, requested):
        name, attribute, texts = _POLICY_TEXTS[policy]
        values = (getattr(profile, attribute) for profile in (offered, requested))
        offer, request = (texts.get(value, "?") if texts else _duration_text(value) for value in values)
        parts.append(f"{name}: {offer} is offered, {request} requested")
    return "; ".join(parts)


def _duration_text(duration_ns: int) -> str:
    return "none" if not duration_ns or duration_ns >= BEST_AVAILABLE_NS else f"{duration_ns / NS_PER_S:g} s"


def last_policy(offered: Profile, requested: Profile) -> QosPolicyKind:
    """The mismatched policy that an event reports: the one with the greatest number, as in Fast DDS.

    A lease is a part of the liveliness there (DDS 1.4, 2.2.3.11).
    """
    lease = QosPolicyKind.RMW_QOS_POLICY_LIVELINESS_LEASE_DURATION
    kinds = [kind for kind, _ in mismatches(offered, requested)]
    return max(QosPolicyKind.RMW_QOS_POLICY_LIVELINESS if kind is lease else kind for kind in kinds)


@cache
def mismatches(offered: Profile, requested: Profile) -> tuple[tuple[QosPolicyKind, str], ...]:
    """Policies by which a publisher's and a subscription's profile do not match, and why; empty if they match."""
    kinds = QosPolicyKind
    checks = (
        (
            offered.reliability == BEST_EFFORT and requested.reliability == RELIABLE,
            kinds.RMW_QOS_POLICY_RELIABILITY,
            "Best effort publisher and reliable subscription",
        ),
        (
            offered.durability == VOLATILE and requested.durability == TRANSIENT_LOCAL,
            kinds.RMW_QOS_POLICY_DURABILITY,
            "Volatile publisher and transient local subscription",
        ),
        (
            _longer(offered.deadline_ns, requested.deadline_ns),
            kinds.RMW_QOS_POLICY_DEADLINE,
            "Subscription deadline is less than publisher deadline",
        ),
        (
            offered.liveliness == AUTOMATIC and requested.liveliness == MANUAL_BY_TOPIC,
            kinds.RMW_QOS_POLICY_LIVELINESS,
            "Publisher's liveliness is automatic and subscription's is manual by topic",
        ),
        (
            _longer(offered.lease_ns, requested.lease_ns),
            kinds.RMW_QOS_POLICY_LIVELINESS_LEASE_DURATION,
            "Subscription's liveliness lease duration is less than publisher's",
        ),
    )
    return tuple((kind, why) for differs, kind, why in checks if differs)


def _longer(offered_ns: int, requested_ns: int) -> bool:
    """Whether more is offered than is requested; nothing said is as good as for ever, and the best available fits."""
    if BEST_AVAILABLE_NS in (offered_ns, requested_ns):
        return False
    return (offered_ns or INFINITE_NS) > (requested_ns or INFINITE_NS)


def _doubts(offered: Profile, requested: Profile) -> list[str]:
    """Policies that may not match, as one of the two leaves them to the system."""
    doubts = []
    for name, could_be, wanted, unknown, offers, requests in (
        ("Reliability", BEST_EFFORT, RELIABLE, _UNKNOWN, offered.reliability, requested.reliability),
        ("Durability", VOLATILE, TRANSIENT_LOCAL, _UNKNOWN, offered.durability, requested.durability),
        ("Liveliness", AUTOMATIC, MANUAL_BY_TOPIC, _UNKNOWN_LIVELINESS, offered.liveliness, requested.liveliness),
    ):
        undecided = (_SYSTEM_DEFAULT, unknown)
        if (offers in undecided and requests in (wanted, *undecided)) or (offers == could_be and requests in undecided):
            doubts.append(f"{name} is left to the system, and may not match")
    return doubts


def check_compatible(offered: Profile, requested: Profile) -> CompatibilityResult:
    """Like `rmw_qos_profile_check_compatible`."""
    errors = mismatches(offered, requested)
    if errors:
        return CompatibilityResult(QoSCompatibility.ERROR, "".join(f"ERROR: {why};" for _, why in errors))
    doubts = _doubts(offered, requested)
    if doubts:
        return CompatibilityResult(QoSCompatibility.WARNING, "".join(f"WARNING: {doubt};" for doubt in doubts))
    return CompatibilityResult()
