"""Offline evaluation of logged runs with numpy; optional, and not used by the plugin itself.

A logged run can be judged again without simulating it, for instance under other requirements. The verdicts equal those
of the monitors (except for the `history` of attempts):

    from pytest_hricdv.monitor.offline import evaluate

    verdicts = evaluate(requirements, Log(record.signals, record.messages, end_s))

Needs the extra `offline`: `pip install pytest-hricdv[offline]`.
"""

try:
    import numpy as _numpy  # noqa: F401
except ModuleNotFoundError as error:
    raise ModuleNotFoundError(
        "offline evaluation of logged runs needs numpy: pip install pytest-hricdv[offline]", name=error.name
    ) from None

from pytest_hricdv.monitor.offline.verdicts import evaluate

__all__ = ["evaluate"]
