"""BDI agents written in AgentSpeak, run as Jason runs them, but deterministically.

Example::

    from pytest_hricdv.bdi import Environment, MultiAgentSystem

    result = MultiAgentSystem.load("models_bdi/table_assembly.mas2j", Environment()).run(max_rounds=1000)
"""

from pytest_hricdv.bdi.language.errors import BdiError, BdiSyntaxError, EvaluationError
from pytest_hricdv.bdi.language.terms import ListTerm, Number, String, Structure, Term, Variable
from pytest_hricdv.bdi.memo import TooLargeError
from pytest_hricdv.bdi.run.environment import Environment
from pytest_hricdv.bdi.run.system import MultiAgentSystem, Result
from pytest_hricdv.bdi.run.tracing import Step, Trace

__all__ = [
    "BdiError",
    "BdiSyntaxError",
    "Environment",
    "EvaluationError",
    "ListTerm",
    "MultiAgentSystem",
    "Number",
    "Result",
    "Step",
    "String",
    "Structure",
    "Term",
    "TooLargeError",
    "Trace",
    "Variable",
]
