"""Requirements as text, judged over a run: Passed, Failed or NC, with counts, times, values and margins.

A requirement is `always(antecedent -> response)`. The antecedent says when the requirement applies, so "not checked"
(NC) is well defined. Both sides are formulas over signals and messages; times are in seconds.

=========================  ==========================================================================================
`on(topic)`                true at the instant at which a message arrives
`topic.field`, `signal`    last value: a condition if bool, a number if float
`a < b` (also <= > >=      comparison of arithmetic; `[hysteresis h]`: once false, true again only past the bound by h;
== !=)                     `[for d]`: true once it has held for d seconds
`! not & |`                boolean, evaluated from left to right
`rise(f)`, `fall(f)`       true at the instant at which f becomes true, false
`previously(f)`            f just before the instant
`once[a:b](f)`             f was true at some time between b and a seconds ago; without [a:b]: ever
`historically[a:b](f)`     f was true at all times between b and a seconds ago; without [a:b]: always
`f since g`                g was true, and f has been true since then
=========================  ==========================================================================================

Responses: `f` (while the antecedent is true), `eventually[a:b](f)`, `always[a:b](f)`, and `always(f) until g` (until g
or the end of the run).

The same formulas can be built in Python, see `pytest_hricdv.monitor.build`; `str(formula)` is the text.

Time is dense: signals are constant between updates, a message exists for one instant, and a deadline is decided at the
deadline. Verdicts do not depend on how finely a run is sampled, nor on signals and messages that a requirement does not
read.

Modules, each built on the ones before it:

- `formula` (the formula as data, and its text), `requirement` (requirement, vocabulary, errors in a text)
- `analysis` (what a formula reads, and when its value can change)
- `parser` (text to formula), `loading` (TOML files); `dsl` and `build` (formulas written in Python)
- `operators` (what compiled formulas read, and operators with memory), `verdict` (the result as data)
- `compiler` (formula to Python functions and operators)
- `requirement_monitor` (the monitor of one requirement), `monitor_set` (the monitors of a run)
- `logged` (logged runs: verdicts on them, and why a requirement was not triggered)

A new operator is added in this order; where a `match` has to be complete, mypy reports the missing case.

1. `formula`: a frozen dataclass with its fields, `__str__` and `PRECEDENCE`, as part of the union `Term`, `PastFormula`
   or `Response`.
2. `requirement.lark`: the rule of the syntax; with a new word, `requirement.KEYWORDS`; with a new terminal,
   `parser._TERMINAL_NAMES`.
3. `parser`: the rule's entry in `_past_rules` or `_term_rules`, with the checks that a user needs.
4. `analysis`: what it reads (`children`, `term_names`, `names_of`), whether it can be true only at isolated instants
   (`is_instantaneous`), and whether its value right after an instant can differ (`is_right_continuous`).
5. `operators`: an `Operator`, if it has memory. `compiler`: its expression, or the operator's constructor. For a
   response: a monitor in `requirement_monitor`.
6. `build`: its function.
7. Tests: the random formulas (`tests/monitor/strategies.py`) and the reference evaluator, with which the monitors are
   compared; cases in `test_semantics`, `test_requirement_text` and `test_build`; the tables of
   `docs/requirements.md` and the one above.
"""

from pytest_hricdv.monitor.formula import Formula
from pytest_hricdv.monitor.loading import check_requirement, load_requirements, parse_formula
from pytest_hricdv.monitor.logged import Log, evaluate, explained
from pytest_hricdv.monitor.monitor_set import MonitorError, MonitorSet
from pytest_hricdv.monitor.requirement import Requirement, RequirementError, Vocabulary
from pytest_hricdv.monitor.verdict import Attempt, NearestMiss, Verdict, Violation

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
    "evaluate",
    "explained",
    "load_requirements",
    "parse_formula",
]
