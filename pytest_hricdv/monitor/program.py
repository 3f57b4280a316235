"""The programs that monitors execute: `compile_formula` compiles a formula once for all runs.

`monitor_of` calls it for requirements and gets a `RequirementProgram`; `MonitorSet.watch` calls `compile_condition`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache

from pytest_hricdv.monitor.analysis import disjuncts, names_of, names_read, topics_of, topics_read
from pytest_hricdv.monitor.compiler import ExpressionCompiler, function_of
from pytest_hricdv.monitor.evaluation_state import Condition, Measure
from pytest_hricdv.monitor.formula import AlwaysWithin, Eventually, Formula, Holds, HoldsUntil
from pytest_hricdv.monitor.node import HysteresisScope, Kind, PastFormula, text_with_names
from pytest_hricdv.monitor.operators import HysteresisOperator, Operator


@dataclass(frozen=True, kw_only=True)
class MonitorProgram:
    """The program of a formula's monitor.

    Attributes:
        condition: a past formula by itself; of a requirement, the formula inside the response.
        run_operators: constructors of the operators over the run, in the order in which they have to be stepped.
        right_continuous: whether the value at an instant is also the value right after it
            (`PastFormula.is_right_continuous`).
        kinds: signals and fields read -> type.
        topics: topics whose messages are read.
        always_sources: sources whose updates always require an evaluation.
        trigger_sources: sources whose updates require an evaluation only while a trigger is open.
    """

    condition: Condition
    run_operators: tuple[Callable[[], Operator], ...]
    right_continuous: bool
    kinds: Mapping[str, Kind]
    topics: frozenset[str]
    always_sources: frozenset[str]
    trigger_sources: frozenset[str] = frozenset()


@dataclass(frozen=True, kw_only=True)
class RequirementProgram(MonitorProgram):
    """The program of one requirement's monitor.

    Attributes:
        antecedent: the requirement's antecedent.
        release: the right side of `until`.
        robustness: the signed distance of `condition` to its bounds; None if it compares nothing, or for `eventually`.
        past_numbers: the text of each count and time between in the formula -> the number of its operator.
        trigger_operators: constructors of the comparisons with hysteresis that are reset at the start of each trigger.
        alternatives: the text of each disjunct of `condition` -> the disjunct; empty if there is only one.
    """

    antecedent: Condition
    release: Condition | None
    past_numbers: Mapping[str, int]
    robustness: Measure | None
    trigger_operators: tuple[Callable[[], HysteresisOperator], ...]
    alternatives: Mapping[str, Condition]


@lru_cache(maxsize=1024)  # as many as a file may have requirements; a session compiles each once for all its runs
def compile_formula(formula: Formula, names: tuple[tuple[PastFormula, str], ...] = ()) -> RequirementProgram:
    """Compile a formula; equal formulas share one program. The alternatives are told by `names` (`Requirement`)."""
    compiler = ExpressionCompiler()
    response = formula.response
    antecedent = formula.antecedent.expression(compiler, HysteresisScope.RUN)
    scope = _hysteresis_scope(formula)
    alternatives = {
        text_with_names(part, dict(names)): part.expression(compiler, scope) for part in disjuncts(response.condition)
    }
    condition = f"({' or '.join(alternatives.values())})"
    release = response.release.expression(compiler, HysteresisScope.RUN) if isinstance(response, HoldsUntil) else None
    robustness = None if isinstance(response, Eventually) else response.condition.robustness(compiler)
    return RequirementProgram(
        antecedent=function_of(antecedent),
        condition=function_of(condition),
        release=None if release is None else function_of(release),
        robustness=None if robustness is None else function_of(robustness),
        past_numbers=compiler.past_numbers,
        run_operators=tuple(compiler.run_operators),
        trigger_operators=tuple(compiler.trigger_operators),
        alternatives={text: function_of(part) for text, part in alternatives.items() if len(alternatives) > 1},
        right_continuous=all(condition.is_right_continuous for condition in formula.conditions),
        kinds=names_read(formula),
        topics=topics_read(formula),
        always_sources=formula.antecedent.sources.union(*compiler.run_sources),
        trigger_sources=frozenset().union(*(part.sources for part in response.children), *compiler.trigger_sources),
    )


@lru_cache(maxsize=1024)
def compile_condition(condition: PastFormula) -> MonitorProgram:
    """Compile a past formula by itself; its hystereses are over the run."""
    compiler = ExpressionCompiler()
    expression = condition.expression(compiler, HysteresisScope.RUN)
    return MonitorProgram(
        condition=function_of(expression),
        run_operators=tuple(compiler.run_operators),
        right_continuous=condition.is_right_continuous,
        kinds=names_of([condition]),
        topics=topics_of([condition]),
        always_sources=condition.sources.union(*compiler.run_sources),
    )


def _hysteresis_scope(formula: Formula) -> HysteresisScope:
    """The scope of the hystereses in the response, so that no trigger fails because of an earlier violation.

    A state response resets them at the start of each trigger. A trigger of `always[a:b]` or of `until` ends with its
    first violation, which is decided at the bound itself, so hysteresis has no effect there.
    """
    match formula.response:
        case Holds():
            return HysteresisScope.TRIGGER
        case AlwaysWithin() | HoldsUntil():
            return HysteresisScope.NEVER
        case Eventually():
            return HysteresisScope.RUN
