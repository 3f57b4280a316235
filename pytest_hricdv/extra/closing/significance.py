"""Whether what came of tries is more than what comes by chance anyway."""

from __future__ import annotations

from math import exp, lgamma, log, log1p

PRIOR = 0.1
"""How probably something does what is wanted before it was tried: of the disturbances of a testbench, few change a
certain thing."""


def significance(came: float, tries: float, by_chance: float) -> float:
    """The probability that something has an effect of its own, of which so many tries had the wanted result.

    By Bayes' theorem of two hypotheses: it has no effect, and results come by chance; or it has one, whose rate is not
    known (uniform from 0 to 1). A result of one try says little where sensors err, and less after a try in vain.

    Args:
        came: the tries with the result; they may be weighted.
        tries: all tries.
        by_chance: the rate of the result without it, above 0 and below 1.
    """
    vain = tries - came
    effect = lgamma(came + 1.0) + lgamma(vain + 1.0) - lgamma(tries + 2.0)
    chance = came * log(by_chance) + vain * log1p(-by_chance)
    odds = PRIOR / (1.0 - PRIOR) * exp(min(effect - chance, 700.0))
    return odds / (1.0 + odds)
