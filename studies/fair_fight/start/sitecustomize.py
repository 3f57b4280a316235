"""Python runs this at its start where the folder is on its path: each process of a tool is metered."""

import os

if "FIGHT_JOURNAL" in os.environ:
    import studies.fair_fight.meter  # noqa: F401
