"""Requirements as text, judged over a run: Passed, Failed or NC, with counts, times, values and margins.

A requirement is `always(antecedent -> response)`. The antecedent says when the requirement applies, so "not checked"
(NC) is well defined. Both sides are formulas over signals and messages; times are in seconds.

The page on requirements has all operators.

Responses: `f` (while the antecedent is true), `eventually[a:b](f)`, `always[a:b](f)`, and `always(f) until g` (until g
or the end of the run).

A number may have a unit, `0.25 rad/s`: it is converted to the declared unit of what it is compared with.

A file of requirements may define names for conditions, numbers and strings that its formulas share.

Outside of requirements, a formula about the present and the past is a condition: `parse_condition` reads it,
`MonitorSet.watch` says online when it becomes true and false, `watch` does so for a logged run.

The same formulas can be built in Python, see `pytest_hricdv.monitor.build`; `str(formula)` is the text.

Time is dense: signals are constant between updates, a message exists for one instant, and a deadline is decided at the
deadline. Verdicts do not depend on how finely a run is sampled, nor on signals and messages that a requirement does not
read.
"""

# Modules, each built on the ones before it:
#
# - `node` (what every part of a formula says about itself), `evaluation_state` (what compiled formulas read)
# - `operators` and `number_operators` (operators with memory)
# - `terms`, `past_formula`, `formula` (formulas as data: their text, analysis and compilation)
# - `units`, `vocabulary` (signals, messages, types), `requirement` (requirement, errors in a text)
# - `compiler` (what formulas are compiled with), `analysis` (what a formula reads, its limits)
# - `syntax_tree`, `term_parser`, `number_parser`, `parser` (text to formula); `dsl` and `build` (formulas written in
#   Python); `patterns` (formulas by name), `pattern_parser` (their text); `loading` (TOML files)
# - `verdict` (the result as data), `program` (what monitors execute)
# - `formula_monitor` (the monitor of a condition), `requirement_monitor` (that of a requirement), `monitor_set` (the
#   monitors of a run)
# - `log` (logged runs), `antecedent` (why a requirement was not triggered, and outcomes of conjuncts),
#   `logged` (verdicts on logged runs)
#
# How to add an operator: CONTRIBUTING.md.

from pytest_hricdv.monitor.evaluation_state import Value
from pytest_hricdv.monitor.formula import Formula
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
from pytest_hricdv.monitor.node import PastFormula
from pytest_hricdv.monitor.requirement import Criterion, FormulaSource, Requirement, RequirementError
from pytest_hricdv.monitor.verdict import NearMiss, RequirementResult, Trigger, Verdict, Violation
from pytest_hricdv.monitor.vocabulary import Vocabulary

__all__ = [
    "ConditionMonitor",
    "Criterion",
    "Formula",
    "FormulaSource",
    "Log",
    "MonitorError",
    "MonitorSet",
    "NearMiss",
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
