"""A deletion of a belief from a source that it never comes from."""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv.bdi.language.errors import Location

from ..model import SELF, Addition, System, name_of, sources_named


class UnmatchedDeletion:
    """Deletions of beliefs that the agent never holds, or never from that source."""

    name = "unmatched-deletion"
    why = (
        "A deletion takes only what came from the source it names, by default the agent itself: this one does nothing."
    )

    def findings(self, system: System) -> Iterator[tuple[Location, str]]:
        """One finding for each deletion."""
        for agent in system.agents:
            held = system.comes_to_hold(agent)
            for mention in agent.deletions:
                key = mention.literal.key
                known = [addition for addition in held if addition.may_be(key)]
                named = sources_named(mention.literal) or frozenset({SELF})
                if not known:
                    yield mention.location, f"nobody ever adds {name_of(key)} to the beliefs of {agent.name}"
                elif None not in named and not any(a.may_be(key, source) for a in known for source in named):
                    wanted = " or ".join(sorted(filter(None, named)))
                    yield (
                        mention.location,
                        f"{name_of(key)} comes to {agent.name} from {_sources(known)}, never from {wanted}",
                    )


def _sources(known: list[Addition]) -> str:
    return " and ".join(sorted({addition.source or "anybody" for addition in known}))
