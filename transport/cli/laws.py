"""Laws: estimates of the experiments compared with exact values, and the smallest bias that the test detects.

All laws of one verification share a family-wise false-alarm rate: the probability that correct code fails
any.
"""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from types import ModuleType

import numpy as np

from transport.statistics.batches import student_quantile
from transport.statistics.estimates import Estimate
from transport.verification.experiment import Outcome, experiment_name

LAWS_FALSE_ALARM = 1e-3  # family-wise rate of a whole verification
POWER = 0.95  # probability to detect the smallest bias
HOLDS, IS_WEAK, WITHOUT_SCORE, FAILS = "holds", "weak", "no score", "FAILS"  # states of a row
WEAK = 0.05  # relative bias that a row must detect, or else it is marked
SHAPE = "χ²"  # in the name of what compares the shape of many bins at once
ROUNDING = 1e-12  # tolerated relative difference of an estimate without spread
# A source has a year or a name, and no signs of a formula.
YEAR_PATTERN, NAME_PATTERN, FORMULA_PATTERN = r"\b(1[5-9]|20)\d\d\b", r"\b[A-ZÀ-Þ]\w\w", r"[=+*^√∫]"


@dataclass(frozen=True)
class Law:
    """A formula with its source, tested by one quantity of one case of an experiment."""

    law: str
    source: str
    sim: str
    quantity: str
    estimate: Estimate
    exact: float

    @property
    def z(self) -> float:
        """Deviation from the exact value as a standard normal score; nan if unknown."""
        return z_score(self.estimate, self.exact)

    def holds(self, false_alarm: float) -> bool:
        """Return whether the estimate agrees with the exact value, two-sided, at this false-alarm rate.

        An estimate of unknown error does not agree, with two exceptions: it is 0 and the exact value is 0, or
        every batch equals the exact value to a relative 1e-12.
        """
        from scipy.special import ndtri

        if self.exact == 0 and self.estimate.value == 0:
            return True
        return bool(abs(self.z) <= -ndtri(false_alarm / 2))

    def state(self, false_alarm: float) -> str:
        """Return FAILS, WITHOUT_SCORE, IS_WEAK or HOLDS."""
        if not self.holds(false_alarm):
            return FAILS
        if math.isnan(self.z):
            return WITHOUT_SCORE  # 0 as it should be, which noise could be too
        return IS_WEAK if self.is_weak(false_alarm) else HOLDS

    def smallest_bias(self, false_alarm: float) -> float:
        """Return the relative bias that `holds` rejects with probability POWER; absolute if exact is 0.

        It comes from the noncentral t distribution; nan if the error is unknown.  For an exact estimate it is
        1e-12, or 0 (any bias) if the exact value is 0.  For an estimate without noise that agrees, it is the
        largest fraction of histories that may deviate although none of those run did.
        """
        return smallest_bias(self.estimate, self.exact, false_alarm)

    @property
    def is_of_shape(self) -> bool:
        """Whether it compares the shape of many bins at once: a bias of χ² is no relative error of a law."""
        return SHAPE in self.quantity

    def is_weak(self, false_alarm: float) -> bool:
        """Return whether a relative bias of WEAK may go unnoticed: such a row shows little."""
        return self.exact != 0 and not self.is_of_shape and not self.smallest_bias(false_alarm) < WEAK


def smallest_bias(estimate: Estimate, exact: float, false_alarm: float, power: float = POWER) -> float:
    """Return the relative bias (absolute if exact is 0) that a two-sided test detects with this power."""
    from scipy.special import nctdtrinc

    if estimate.exact:
        return ROUNDING if exact != 0 else 0.0
    if is_exact_in_every_batch(estimate, exact):
        return max(ROUNDING, -math.log(1 - power) / estimate.run.histories)
    if math.isnan(estimate.error):
        return math.nan
    limit = student_quantile(1 - false_alarm / 2, estimate.dof)
    shift = float(nctdtrinc(estimate.dof, 1 - power, limit)) * estimate.error
    return shift / abs(exact) if exact != 0 else shift


def z_score(estimate: Estimate, exact: float) -> float:
    """Return the deviation of an estimate as a standard normal score; nan if unknown.

    An estimate without noise scores 0 if it agrees.  If it does not, its score is unknown, because counts may
    be equal by chance.
    """
    if math.isnan(exact):
        return math.nan
    return 0.0 if is_exact_in_every_batch(estimate, exact) else estimate.z(exact)


def is_exact_in_every_batch(estimate: Estimate, exact: float) -> bool:
    """Return whether every batch equals the exact value to a relative 1e-12."""
    if estimate.exact or estimate.run is None or estimate.batches < 2 or estimate.value == 0:
        return False
    return bool((np.abs(estimate.values - exact) <= ROUNDING * abs(exact)).all())


def laws_of(module: ModuleType, outcomes: list[Outcome]) -> Iterator[Law]:
    """Yield one law per row of each case that has an exact value."""
    law, source = split_law(getattr(module, "law", ""))
    for outcome in outcomes:
        for row in outcome.rows:
            if not math.isnan(row.exact):
                name = row_name(outcome, row.name, len(outcomes))
                yield Law(law, source, experiment_name(module), name, row.estimate, row.exact)


def row_name(outcome: Outcome, quantity: str, cases: int) -> str:
    """Return the quantity's name, preceded by the case if there are several."""
    return quantity if cases == 1 or not outcome.title else f"{outcome.title}: {quantity}"


def split_law(text: str) -> tuple[str, str]:
    """Split "E = π L sin²θ (Nusselt 1928)" or "E = π L sin²θ; Nusselt 1928" into formula and source.

    A source has a name or a year; other text in brackets belongs to the formula.
    """
    text = " ".join(text.split()).rstrip(".")
    match = re.fullmatch(r"(.*\S)\s+\(((?:[^()]|\([^()]*\))*)\)", text)
    if match and _is_source(match[2]):
        return match[1].rstrip(",;:"), match[2]
    formula, _, source = text.rpartition("; ")
    return (formula, source) if formula and _is_source(source) else (text, "")


def _is_source(text: str) -> bool:
    has_author = re.search(YEAR_PATTERN, text) or re.search(NAME_PATTERN, text)
    return bool(has_author) and not re.search(FORMULA_PATTERN, text)
