"""Requirements as text, judged over a run: Passed, Failed or NC, with counts, times, values and margins.

A requirement is `always(antecedent -> response)`: the antecedent says when it applies, so "not checked" is well
defined. Both sides are formulas over signals and messages; times are seconds.

=========================  ==========================================================================================
`on(topic)`                true at the instant at which a message arrives
`topic.field`, `signal`    last value: a condition if bool, a number if float
`a < b` (also <= > >=      comparison of arithmetic; `[hysteresis h]`: once false, true again only past the bound by h;
== !=)                     `[for d]`: true once it has held for d seconds
`! not & |`                boolean, evaluated from left to right
`rise(f)`, `fall(f)`       true at the instant at which f turns true, false
`previously(f)`            f as it was just before
`once[a:b](f)`             f was true somewhere between b and a seconds ago; without [a:b]: ever
`historically[a:b](f)`     f was true all the time between b and a seconds ago; without [a:b]: always
`f since g`                g was true, and f has been ever since
=========================  ==========================================================================================

Responses: `f` (as long as the antecedent holds), `eventually[a:b](f)`, `always[a:b](f)`, and `always(f) until g` (until
g or the end of the run).

The same can be built in Python, see `pytest_hricdv.monitor.build`; `str(formula)` is its text.

Time is dense: signals are constant between updates, a message is there for an instant, a deadline is decided at the
deadline. Verdicts do not depend on how finely a run is sampled, nor on what a requirement does not read.
"""

from pytest_hricdv.monitor.errors import MonitorError, RequirementError
from pytest_hricdv.monitor.formula import Formula
from pytest_hricdv.monitor.log import Log
from pytest_hricdv.monitor.miss import explained
from pytest_hricdv.monitor.monitor import MonitorSet
from pytest_hricdv.monitor.requirement import Requirement, check_requirement, load_requirements, parse_formula
from pytest_hricdv.monitor.verdict import Attempt, NearestMiss, Verdict, Violation
from pytest_hricdv.monitor.vocabulary import Vocabulary

__all__ = [
    "Attempt",
    "Formula",
    "Log",
    "MonitorError",
    "MonitorSet",
    "NearestMiss",
    "Requirement",
    "RequirementError",
    "Verdict",
    "Violation",
    "Vocabulary",
    "check_requirement",
    "explained",
    "load_requirements",
    "parse_formula",
]
