"""Laws judged: each estimate of the experiments against its exact value, and the smallest bias that would be caught.

All laws of one verification share a family-wise rate of false alarms: the probability that right code fails in any.
"""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from types import ModuleType

from transport.experiment import Outcome, name_of
from transport.results.estimates import Estimate
from transport.results.statistics import student_quantile

FALSE_ALARM = 1e-3  # of a whole verification, over all seeds
POWER = 0.95  # probability with which the smallest bias is caught
ROUNDING = 1e-12  # relative difference that an estimate without spread may have


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
        """How many standard errors the estimate is off, as a standard normal score."""
        return self.estimate.z(self.exact)

    def holds(self, false_alarm: float) -> bool:
        """Whether the estimate agrees, two-sided, at this rate of false alarms.

        One of unknown error does not, but for 0 where 0 is exact: nothing came where nothing can.
        """
        from scipy.special import ndtri

        if self.exact == 0 and self.estimate.value == 0:
            return True
        return bool(abs(self.z) <= -ndtri(false_alarm / 2))

    def smallest_bias(self, false_alarm: float) -> float:
        """The relative bias that `holds` rejects with the probability POWER; in the unit where exact is 0.

        From the noncentral t distribution; nan where the error is unknown.  Where the estimate has no spread it is
        1e-12, and 0 (any bias) where exact is 0.
        """
        return smallest_bias(self.estimate, self.exact, false_alarm)


def smallest_bias(estimate: Estimate, exact: float, false_alarm: float, power: float = POWER) -> float:
    """Relative bias (absolute where exact is 0) that a two-sided test of this level catches with this power."""
    from scipy.special import nctdtrinc

    if estimate.exact:
        return ROUNDING if exact != 0 else 0.0
    if math.isnan(estimate.error):
        return math.nan
    limit = student_quantile(1 - false_alarm / 2, estimate.dof)
    shift = float(nctdtrinc(estimate.dof, 1 - power, limit)) * estimate.error
    return shift / abs(exact) if exact != 0 else shift


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
    """Formula and source of a law in a line, "E = π L sin²θ (Nusselt 1928)": the last brackets hold the source."""
    text = " ".join(text.split()).rstrip(".")
    if match := re.fullmatch(r"(.*\S)\s*\(((?:[^()]|\([^()]*\))*)\)", text):
        return match[1].rstrip(",;:"), match[2]
    formula, semicolon, source = text.rpartition("; ")
    return (formula, source) if semicolon else (text, "")
