"""Requirements as text, judged over a run: Passed, Failed or NC, with counts, times, values and margins.

A requirement is `always(antecedent -> response)`. The antecedent says when the requirement applies, so "not checked"
(NC) is well defined. Both sides are formulas over signals and messages; times are in seconds.

=========================  ==========================================================================================
`on(topic)`                true at the instant at which a message arrives
`topic.field`, `signal`    last value: a condition if bool, a number if float, a text if str; a topic with one number or
                           text may be written without it: `state` for `state.name`
`a < b` (also <= > >=      comparison of arithmetic; `[hysteresis h]`: once false, true again only past the bound by h;
== !=)                     `[for d]`: true once it has held for d seconds
`state == "Idle"`, `!=`    comparison of texts, also with `[for d]`; false before there is a value
`! not & |`                boolean, evaluated from left to right
`rise(f)`, `fall(f)`       true at the instant at which f becomes true, false
`previously(f)`            f just before the instant
`once[a:b](f)`             f was true at some time between b and a seconds ago; without [a:b]: ever
`historically[a:b](f)`     f was true at all times between b and a seconds ago; without [a:b]: always
`f since g`                g was true, and f has been true since then
`time_since(f) < d`        f was last true less than d seconds ago (also <= > >=); infinite before f was ever true
`count[a:b](f)`            a number: how often f became true between b and a seconds ago; without [a:b]: so far
`last(topic.field)`        the value in the message before the present one; a comparison is false before there is one
`time_between(f, g)`       a number: the time (s) from when f last became true to when g last did; a comparison is false
                           before there is one
=========================  ==========================================================================================

Responses: `f` (while the antecedent is true), `eventually[a:b](f)`, `always[a:b](f)`, and `always(f) until g` (until g
or the end of the run).

A number may have a unit, `0.25 rad/s`: it is converted to the declared unit of what it is compared with.

A file of requirements may define names for conditions, numbers and texts that its formulas share.

Outside of requirements, a formula about the present and the past is a condition: `parse_condition` reads it,
`MonitorSet.watch` says online when it becomes true and false, `watch` does so for a logged run.

The same formulas can be built in Python, see `pytest_hricdv.monitor.build`; `str(formula)` is the text.

Time is dense: signals are constant between updates, a message exists for one instant, and a deadline is decided at the
deadline. Verdicts do not depend on how finely a run is sampled, nor on signals and messages that a requirement does not
read.
"""

# Modules, each built on the ones before it:
#
# - `node`, `past_formula`, `formula` (formulas as data, and their text), `units` (units of measurement)
# - `vocabulary` (signals, messages, types), `requirement` (requirement, errors in a text)
# - `analysis` (what a formula reads, and when its value can change), `limit` (the limits in it, for pictures)
# - `syntax_tree`, `term_parser`, `number_parser`, `parser` (text to formula); `dsl` and `build` (formulas written in
#   Python); `patterns` (formulas by name), `pattern_parser` (their text); `loading` (TOML files)
# - `evaluation_state` (what compiled formulas read), `verdict` (the result as data)
# - `operators` and `number_operators` (operators with memory), `compiler` (formula to Python functions and operators),
#   `program` (what monitors execute)
# - `formula_monitor` (the monitor of a condition), `requirement_monitor` (that of a requirement), `monitor_set` (the
#   monitors of a run)
# - `log` (logged runs), `antecedent` (why a requirement was not triggered, and outcomes of conjuncts), `logged`
#   (verdicts on logged runs)
#
# How to add an operator: CONTRIBUTING.md.

from pytest_hricdv.monitor.evaluation_state import Value
from pytest_hricdv.monitor.formula import Formula, PastFormula
from pytest_hricdv.monitor.formula_monitor import ConditionMonitor
from pytest_hricdv.monitor.loading import (
    check_requirement,
    load_definitions,
    load_requirements,
    parse_condition,
    parse_formula,
)
from pytest_hricdv.monitor.log import Log
from pytest_hricdv.monitor.logged import evaluate, explain, watch
from pytest_hricdv.monitor.monitor_set import MonitorError, MonitorSet
from pytest_hricdv.monitor.requirement import Criterion, FormulaSource, Requirement, RequirementError
from pytest_hricdv.monitor.verdict import NearestMiss, RequirementResult, Trigger, Verdict, Violation
from pytest_hricdv.monitor.vocabulary import Vocabulary

__all__ = [
    "ConditionMonitor",
    "Criterion",
    "Formula",
    "FormulaSource",
    "Log",
    "MonitorError",
    "MonitorSet",
    "NearestMiss",
    "PastFormula",
    "Requirement",
    "RequirementError",
    "RequirementResult",
    "Trigger",
    "Value",
    "Verdict",
    "Violation",
    "Vocabulary",
    "check_requirement",
    "evaluate",
    "explain",
    "load_definitions",
    "load_requirements",
    "parse_condition",
    "parse_formula",
    "watch",
]
