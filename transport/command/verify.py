"""Laws judged: each estimate of the experiments against its exact value, and the smallest bias that would be caught.

All laws of one verification share a family-wise rate of false alarms: the probability that right code fails in any.
"""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from types import ModuleType

import numpy as np

from transport.experiment import Outcome, name_of
from transport.results.estimates import Estimate
from transport.results.statistics import student_quantile

FALSE_ALARM = 1e-3  # of a whole verification, over all seeds
POWER = 0.95  # probability with which the smallest bias is caught
ROUNDING = 1e-12  # relative difference that an estimate without spread may have
# What a source has, and what it has not.
YEAR, NAME, SUM = r"\b(1[5-9]|20)\d\d\b", r"\b[A-ZÀ-Þ]\w\w", r"[=+*^√∫]"


@dataclass(frozen=True)
class Law:
    """A formula with its source, shown by one quantity of one case of an experiment."""

    law: str
    source: str
    sim: str
    quantity: str
    estimate: Estimate
    exact: float

    @property
    def z(self) -> float:
        """How many standard errors the estimate is off, as a standard normal score; nan where that is unknown."""
        return score_of(self.estimate, self.exact)

    def holds(self, false_alarm: float) -> bool:
        """Whether the estimate agrees, two-sided, at this rate of false alarms.

        One of unknown error does not, but for 0 where 0 is exact: nothing came where nothing can; and for one without
        noise, where every batch gave what is exact to 1e-12 of it.
        """
        from scipy.special import ndtri

        if self.exact == 0 and self.estimate.value == 0:
            return True
        return bool(abs(self.z) <= -ndtri(false_alarm / 2))

    def smallest_bias(self, false_alarm: float) -> float:
        """The relative bias that `holds` rejects with the probability POWER; in the unit where exact is 0.

        From the noncentral t distribution; nan where the error is unknown.  Where the estimate is exact it is 1e-12,
        and 0 (any bias) where exact is 0.  Where it is right without noise, what a share of the histories may do
        that did so in none of them.
        """
        return smallest_bias(self.estimate, self.exact, false_alarm)


def smallest_bias(estimate: Estimate, exact: float, false_alarm: float, power: float = POWER) -> float:
    """Relative bias (absolute where exact is 0) that a two-sided test of this level catches with this power."""
    from scipy.special import nctdtrinc

    if estimate.exact:
        return ROUNDING if exact != 0 else 0.0
    if is_right_without_noise(estimate, exact):
        return max(ROUNDING, -math.log(1 - power) / int(estimate.run.sizes.sum()))
    if math.isnan(estimate.error):
        return math.nan
    limit = student_quantile(1 - false_alarm / 2, estimate.dof)
    shift = float(nctdtrinc(estimate.dof, 1 - power, limit)) * estimate.error
    return shift / abs(exact) if exact != 0 else shift


def score_of(estimate: Estimate, exact: float) -> float:
    """How many standard errors an estimate is off, as a standard normal score; nan where that is unknown.

    0 for one without noise that is right.  A wrong one that every batch gave has an unknown score: counts may be alike
    by chance.
    """
    if math.isnan(exact):
        return math.nan
    return 0.0 if is_right_without_noise(estimate, exact) else estimate.z(exact)


def is_right_without_noise(estimate: Estimate, exact: float) -> bool:
    """Whether every batch gave the exact value, to 1e-12 of it."""
    if estimate.exact or estimate.run is None or estimate.batches < 2 or estimate.value == 0:
        return False
    return bool((np.abs(estimate.values - exact) <= ROUNDING * abs(exact)).all())


def laws_of(module: ModuleType, outcomes: list[Outcome]) -> Iterator[Law]:
    """One law a row of each case's table, of those with an exact value."""
    law, source = split_law(getattr(module, "law", ""))
    for outcome in outcomes:
        for row in outcome.rows:
            if not math.isnan(row.exact):
                name = row_name(outcome, row.name, len(outcomes))
                yield Law(law, source, name_of(module), name, row.estimate, row.exact)


def row_name(outcome: Outcome, quantity: str, cases: int) -> str:
    """The quantity's name, with the case in front where there are several."""
    return quantity if cases == 1 or not outcome.title else f"{outcome.title}: {quantity}"


def split_law(text: str) -> tuple[str, str]:
    """Formula and source of a law in a line, "E = π L sin²θ (Nusselt 1928)": the last brackets hold the source.

    Or "E = π L sin²θ; Nusselt 1928".  A source names somebody or a year; what else is in brackets is the formula's.
    """
    text = " ".join(text.split()).rstrip(".")
    match = re.fullmatch(r"(.*\S)\s+\(((?:[^()]|\([^()]*\))*)\)", text)
    if match and _is_source(match[2]):
        return match[1].rstrip(",;:"), match[2]
    formula, _, source = text.rpartition("; ")
    return (formula, source) if formula and _is_source(source) else (text, "")


def _is_source(text: str) -> bool:
    return bool(re.search(YEAR, text) or re.search(NAME, text)) and not re.search(SUM, text)
