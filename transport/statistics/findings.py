"""Findings: what a run may have missed of a number, by how much, and what to do about it.

An estimator connects some classes of paths exactly and finds others only by chance.  A class without a score
has no variance, so the standard error omits it.  Poisson's law bounds the contribution of such a class, and
one judge compares the bound with the standard error, the value and the requested error.  Warnings, reports,
`quality()`, pictures, stopping and the choice of an estimator read the same findings.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from transport.statistics.batches import MIN_SCORES_FOR_ERROR
from transport.statistics.notation import ratio_text

USE_MORE = "use more particles"
MORE_PARTICLES = "use more particles, or estimator='auto', which compares the estimators that suit the scene"
MAX_FORETOLD = 4 * MIN_SCORES_FOR_ERROR**2  # factor of the number of histories that a run waits for
MAX_ADVISED_PARTICLES = 1e12  # particles
CONFIDENCE = 0.95  # of the bounds of unseen contributions
FEW_CARRIERS, UNKNOWN = "few carriers", "unknown error"  # entries of the table of diagnostics
NEGLIGIBLE_BOUND = 0.01  # relative to the error: a smaller bound is not reported
DEFAULT_ALLOWED_BOUND = 0.01  # relative to the value: limit of a bound if no error was requested

NOTE, SOUND, BOUNDED, DOUBTFUL = "note", "sound", "bounded", "doubtful"
NO_SCORE, CONSTANT = "no score", "every batch gave the same"  # reasons for an unknown error
# Batches: that so many get the same number of scores (not 0) by chance happens once in e^14 = 1.2e6 runs.
MIN_EQUAL_BATCHES = 14
SEVERITIES = (NOTE, BOUNDED, DOUBTFUL)


@dataclass(frozen=True, eq=False)
class Finding:
    """Result of a check or diagnostic about a number.

    Parameters
    ----------
    severity : {"note", "bounded", "doubtful"}
        "note": information, the number stands.  "bounded": the number may be off by `bound`, and `interval()`
        includes it.  "doubtful": the number may be off by more than its error and more than is allowed.
    object : str
        The detector, source or surface concerned, such as "detector 'desk'".
    quantity : str
        The quantity, such as "irradiance"; "" for all quantities of the object.
    what : str
        What may be wrong, such as "light via 'mirror' not sampled".
    bound : float or numpy.ndarray, default nan
        By how much the true value may exceed the estimate (fall below it, if negative), in the unit of the
        quantity, with 95 % confidence; nan if no bound is known.  Shape (*dims) for an array.
    cure : str, default ""
        What to do, such as "use estimator='backward'".
    value : float, default nan
        Value of the number concerned.
    name : str, default ""
        Name of the diagnostic in the table of `transport checks`.
    seen : str, default ""
        Evidence in the run that it is more than a possibility.
    times : float, default nan
        Factor of the number of histories after which the error includes it; nan if no score predicts it.
    particles : float, default nan
        The same as a number of particles of a run, which the cure names; nan for findings of single numbers.
    about : float, default nan
        Expected contribution as a fraction of `bound`, if a probe measured it.
    adds : bool, default False
        For bins: whether each bin has its own part of the bound; otherwise any one bin may have all of it.
    is_foretold : bool, default False
        Whether scores show how large the bound is beside the value, so that a run for an error goes on until
        it is allowed.
    others : str, default ""
        How many smaller doubtful findings the number has, and where to read them.

    Examples
    --------
    >>> from transport.statistics.findings import Finding
    >>> print(Finding("doubtful", "detector 'm'", "irradiance", "light via 'mirror' not sampled"))
    irradiance of detector 'm': light via 'mirror' not sampled
    """

    severity: str
    object: str
    quantity: str
    what: str
    bound: Any = np.nan
    cure: str = ""
    value: float = np.nan
    name: str = ""
    seen: str = ""
    times: float = np.nan
    about: float = np.nan
    adds: bool = False
    others: str = ""
    particles: float = np.nan
    is_foretold: bool = False

    @property
    def share(self) -> float:
        """The bound as a fraction of the value; nan if it is not known.

        Returns
        -------
        float
        """
        return abs(self.bound / self.value) if np.ndim(self.bound) == 0 and self.value else np.nan

    @property
    def worth(self) -> str:
        """The bound relative to the value, in words; "" if it is not known.

        Returns
        -------
        str
        """
        share = self.share
        if not np.isfinite(share):
            return ""
        if share < 0.995:
            return f", worth up to {100 * share:.2g} % of it"
        return (
            f", worth up to {ratio_text(share)} times it" if share >= 1.05 else ", worth up to as much as it"
        )

    @property
    def advice(self) -> str:
        """The cure, with the approximate number of particles if it is known and within reach.

        Returns
        -------
        str
        """
        if not self.particles < MAX_ADVISED_PARTICLES:
            return self.cure
        power = 10 ** math.floor(math.log10(self.particles))
        number = f"{math.ceil(self.particles / power) * power:.0e}".replace("e+0", "e").replace("e+", "e")
        return self.cure.replace("more particles", f"about {number} particles")

    def record(self) -> dict[str, Any]:
        """Return the fields as a dictionary of JSON types.

        Returns
        -------
        dict of str
            Keys "name", "severity", "object", "quantity", "what", "bound", "seen" and "cure", which is the
            advice.
        """
        bound = self.bound.tolist() if isinstance(self.bound, np.ndarray) else float(self.bound)
        names = ("name", "severity", "object", "quantity", "what", "bound", "seen", "cure")
        return {name: getattr(self, name) for name in names} | {"bound": bound, "cure": self.advice}

    def __str__(self) -> str:
        of = " of ".join(filter(None, (self.quantity, self.object)))
        what = f"{of}: {self.what}{self.worth}" if of else self.what
        what += f" ({self.seen})" if self.seen else ""
        return f"{what}. {capitalized(self.advice)}" if self.cure else what


class Check(NamedTuple):
    """An entry of the table of checks and diagnostics (`transport checks`).

    name: of its findings;  detects, cannot_detect: what it finds and what it misses;  run: of a scene it
    raises an error, of a result it returns the texts of notes; None for what single tallies are examined for.
    """

    name: str
    detects: str
    cannot_detect: str = ""
    run: Callable[[Any], Iterable[str] | None] | None = None

    def record(self) -> dict[str, str]:
        """Return the words as a dictionary of JSON types."""
        return {"name": self.name, "detects": self.detects, "cannot_detect": self.cannot_detect}


def doubtful(name: str, what: str, bound: Any = np.nan, cure: str = USE_MORE, **evidence: Any) -> Finding:
    """Return a finding that counts against a number until it is judged (`severities`).

    name: of its entry in the table of diagnostics;  evidence: further fields, such as `seen` or `times`.
    """
    return Finding(DOUBTFUL, "", "", what, bound, cure, name=name, **evidence)


def note(name: str, what: str) -> Finding:
    """Return a finding that informs and counts against no number; name: of its entry in the table."""
    return Finding(NOTE, "", "", what, name=name)


def unseen_scores(scores: float | np.ndarray) -> Any:
    """Number of scores possible beyond the counted ones: U(n) - n, with U Poisson's 95 % upper limit.

    3.0 for n = 0; 0 from MIN_SCORES_FOR_ERROR on, because the standard error includes the spread of so many.

    Examples
    --------
    >>> round(unseen_scores(0), 2), round(unseen_scores(1), 2), unseen_scores(MIN_SCORES_FOR_ERROR)
    (3.0, 3.74, 0.0)
    """
    from scipy.special import gammaincinv

    scores = np.asarray(scores, dtype=float)
    unseen = np.where(scores < MIN_SCORES_FOR_ERROR, gammaincinv(scores + 1.0, CONFIDENCE) - scores, 0.0)
    return unseen.item() if unseen.ndim == 0 else unseen


def few_scores_findings(scores: float, value: float, error: float, is_sum: bool) -> tuple[Finding, ...]:
    """Findings against the error of a single number with few scores; none without a score or with enough.

    is_sum: whether it is a sum of scores none of which is negative.  Then about (value/error)^2 of them are
    independent: several scores of one history often count once.
    """
    independent = min(scores, (value / error) ** 2) if is_sum and error > 0 else scores
    if not 0 < independent < MIN_SCORES_FOR_ERROR:
        return ()
    what = f"only {scores:g} score{'s' * (scores > 1)}, too few to know the error"
    unseen = 0.0
    if scores < MIN_SCORES_FOR_ERROR:
        unseen = unseen_scores(scores) / scores * value
    else:
        many = f" {scores:.0f}" if math.isfinite(scores) else ""
        what = (
            f"its{many} scores spread as {max(independent, 1):.2g} independent ones do,"
            " too few to know the error"
        )
    bound = max(unseen, error_uncertainty(independent) * error) if is_sum and error > 0 else unseen
    times = MIN_SCORES_FOR_ERROR / max(independent, 1)
    return (doubtful(FEW_CARRIERS, what, bound, times=times),)


def even_scores_findings(
    value: np.ndarray, error: np.ndarray, scores: np.ndarray, histories: int
) -> tuple[Finding, ...]:
    """Findings against errors smaller than one score is worth: batches may all have one too many or too few.

    If the expected number of scores lies between two whole numbers, even points give all batches the same
    number, with a chance of 5 % where 3 more or fewer are expected in all of them.  A number with a score of
    every history is excluded.  Arrays (*dims).
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        is_blind = (scores > 0) & (error * scores < np.abs(value)) & (scores % histories != 0)
        bound = np.where(is_blind, unseen_scores(0) / scores * np.abs(value), 0.0)
    if not is_blind.any():
        return ()
    what = "evenly spread points may give every batch the same few scores too many or too few"
    bound = bound.item() if bound.ndim == 0 else bound
    return doubtful(UNKNOWN, what, bound), doubtful(UNKNOWN, what, -bound)


def weak_denominator_findings(value: np.ndarray, error: np.ndarray) -> tuple[Finding, ...]:
    """Findings against a ratio whose denominator (*dims) may be near 0.

    Its error is propagated by derivatives, which hold if the denominator is as certain as
    MIN_SCORES_FOR_ERROR scores make it.
    """
    with np.errstate(invalid="ignore"):
        is_weak = error**2 * MIN_SCORES_FOR_ERROR > value**2
    if not is_weak.any():
        return ()
    what = (
        f"the denominator is uncertain by more than {100 / np.sqrt(MIN_SCORES_FOR_ERROR):.0f} %, too much"
        " to know the error of a ratio"
    )
    return (_unbounded_finding(FEW_CARRIERS, what, is_weak),)


def _unbounded_finding(name: str, what: str, where: np.ndarray, seen: str = "") -> Finding:
    """A finding without a bound about the numbers of an array where `where`, (*dims) of bool, is true."""
    bound = np.where(where, np.nan, 0.0)
    return doubtful(name, what, float(bound) if bound.ndim == 0 else bound, seen=seen)


def error_uncertainty(carriers: float) -> float:
    """Standard errors by which a 95 % interval may be too short if `carriers` scores carry the error.

    Their variance is as uncertain as that of 2n normal numbers (chi squared, 95 %); 0.7 for ten, 1.2 for
    five.

    Examples
    --------
    >>> print(f"{error_uncertainty(5.0):.1f}, {error_uncertainty(1e6):.1f}")
    1.2, 0.0
    """
    from scipy.special import chdtri

    if not carriers > 0:
        return np.inf
    dof = 2 * max(carriers, 0.5)
    return 1.96 * (np.sqrt(dof / chdtri(dof, CONFIDENCE)) - 1)


def severities(finding: Finding, value: np.ndarray, error: np.ndarray, allowed: float) -> np.ndarray:
    """The verdict about each number of an array by one finding: the one judge.

    Sound if the bound is below the standard error, bounded if it is below the allowed share of the value,
    doubtful otherwise and if no bound is known.
    """
    if finding.severity == NOTE:
        return np.broadcast_to(SOUND, np.shape(value))
    bound = np.abs(np.broadcast_to(finding.bound, np.shape(value)))
    with np.errstate(invalid="ignore"):
        is_small, is_allowed = bound <= error, bound <= allowed * np.abs(value)
    is_small |= bound == 0
    return np.where(is_small, SOUND, np.where(is_allowed, BOUNDED, DOUBTFUL))


def unknown_error_limits(
    reasons: np.ndarray,
    scale: np.ndarray,
    scores: np.ndarray,
    histories: int,
    is_sure: bool,
    findings: Iterable[Finding],
) -> np.ndarray:
    """Limits of numbers with unknown error, besides the bounds of findings, (*dims); infinite if unknown.

    reasons: (*dims) of str, None where the error is known;  scale: size of the largest term of each number;
    scores: of each number;  histories: of the smallest run;  is_sure: whether the equality of its batches is
    not chance, because there are many or their points are even.  0 where a number has no score and a finding
    bounds it.  What is equal in such batches is equal for all but 3 of the histories, with 95 % confidence,
    and a history that differs may have or lack a score.
    """
    bounds = [np.abs(np.broadcast_to(finding.bound, np.shape(scale))) for finding in findings]
    in_all = np.sum(bounds, axis=0) if bounds else np.zeros(np.shape(scale))  # nan if any is unknown
    is_bounded = np.equal(reasons, NO_SCORE) & (in_all > 0) & np.isfinite(in_all)
    alike = unseen_scores(0) * scale / np.clip(scores, 1, histories) if is_sure else np.inf
    limits = np.where(np.equal(reasons, CONSTANT), alike, np.inf)
    return np.where(np.equal(reasons, None) | is_bounded, 0.0, limits)


def unknown_error_findings(reasons: np.ndarray, limits: np.ndarray) -> tuple[Finding, ...]:
    """Findings against numbers with unknown error.

    limits: from `unknown_error_limits`, (*dims) as the reasons.
    """
    known = [reason for reason in np.ravel(reasons)[np.ravel(limits) > 0] if reason is not None]
    if not known:
        return ()
    is_limited = known[0] == CONSTANT and np.isfinite(limits).all()
    what = {CONSTANT: CONSTANT if is_limited else "", NO_SCORE: "no score, so the value is unknown, not 0"}
    what = what.get(known[0]) or f"the error is unknown: {known[0]}"
    many = f" in {len(known)} of {np.size(reasons)} bins" if np.ndim(reasons) else ""
    bound = np.asarray(limits)
    return (doubtful(UNKNOWN, what + many, float(bound) if bound.ndim == 0 else bound),)


def bin_findings(is_doubtful: np.ndarray) -> tuple[Finding, ...]:
    """Findings against bins whose error is unknown even with neighbouring bins.

    is_doubtful: (*dims) of bool.
    """
    many = int(np.count_nonzero(is_doubtful))
    if not many:
        return ()
    what = "too few or too unequal scores, even with those of neighbouring bins"
    seen = f"in {many} of {np.size(is_doubtful)} bins" if np.ndim(is_doubtful) else ""
    return (_unbounded_finding("bins", what, is_doubtful, seen),)


def worst_verdicts(verdicts: Iterable[np.ndarray], shape: tuple[int, ...]) -> np.ndarray:
    """The worst verdict about each number, shape (*shape)."""
    worst = np.full(shape, SOUND, dtype="<U8")
    for verdict in verdicts:
        worst = np.where(worst == DOUBTFUL, worst, np.where(verdict == SOUND, worst, verdict))
    return worst


def particle_factors_needed(
    findings: Iterable[Finding], value: float, error: float, allowed: float
) -> tuple[float, float, str]:
    """Factors of the number of histories until no finding is doubtful, and the finding that needs most.

    The first factor covers findings with scores that predict it.  The second covers findings without a score:
    the number that a probe predicts, or the number until their bound, which falls as one over the number of
    histories, is allowed.  A factor is 1 if there are no such findings and infinite if there is no bound.
    """
    foretold, open_end, worst, what = 1.0, 1.0, 1.0, ""
    number, spread = np.asarray(value), np.asarray(error)
    doubts = [each for each in findings if str(severities(each, number, spread, allowed)) == DOUBTFUL]
    bounded = [each for each in doubts if not np.isnan(each.bound)]  # they explain the batches
    for finding in bounded or doubts:
        if np.isfinite(finding.about):  # its own error, from its scores, shall be within the allowed one
            share = finding.about * abs(finding.bound) / (allowed * abs(value)) if value else np.inf
            times = open_end = max(open_end, float(finding.times * max(1.0, share**2 / MIN_SCORES_FOR_ERROR)))
        elif np.isfinite(finding.times) or finding.is_foretold:
            share = abs(finding.bound) / (allowed * abs(value)) if value else np.inf
            times = float(share if finding.is_foretold else finding.times)
            if times <= MAX_FORETOLD:
                foretold = max(foretold, times)
            else:  # too far away to be waited for
                open_end = max(open_end, times)
        else:
            times = abs(finding.bound) / (allowed * abs(value)) if value else np.inf
            times = open_end = max(open_end, float(np.nan_to_num(times, nan=np.inf)))
        if times >= worst:
            worst, what = times, finding.what
    return foretold, open_end, what


def with_severities(
    findings: Iterable[Finding], value: np.ndarray, error: np.ndarray, allowed: float
) -> tuple[Finding, ...]:
    """The findings with their severity for a number, the worst first.

    Findings that do not matter are notes.
    """
    found, size = [], np.nan_to_num(np.abs(value))
    for finding in findings:
        verdicts = severities(finding, value, error, allowed)
        if finding.severity != NOTE and np.all(
            np.nan_to_num(np.abs(finding.bound), nan=np.inf) <= NEGLIGIBLE_BOUND * error
        ):
            continue
        severity = (
            DOUBTFUL if (verdicts == DOUBTFUL).any() else BOUNDED if (verdicts == BOUNDED).any() else NOTE
        )
        known = float(value) if np.ndim(value) == 0 else np.nan
        with np.errstate(divide="ignore", invalid="ignore"):
            shares = np.abs(finding.bound) / size
        weight = np.max(np.where(np.isnan(shares), 0.0, shares), initial=0.0)
        found.append((SEVERITIES.index(severity), weight, replace(finding, severity=severity, value=known)))
    return tuple(finding for *_, finding in sorted(found, key=lambda each: each[:2], reverse=True))


def propagated_findings(
    function: Callable, *operands: tuple[np.ndarray, Iterable[Finding]]
) -> tuple[Finding, ...]:
    """Propagate findings through a function of numbers: each bound becomes the change of the function.

    operands: for each number its value and its findings.  Findings of one kind and sign merge into one.  If
    the operands before may be larger too, a product changes by more: those operands are shifted by all that
    they may miss.
    """
    values = [value for value, _ in operands]
    found: dict[tuple[str, str, bool], Finding] = {}
    with np.errstate(all="ignore"):
        for place, (value, findings) in enumerate(operands):
            base = function(*values)
            for finding in findings:
                bound = function(*values[:place], value + finding.bound, *values[place + 1 :]) - base
                key = finding.object, finding.what, bool(np.all(np.nan_to_num(bound) >= 0))
                # Keep contributions that add to a number apart from those that reduce it.
                if (other := found.get(key)) is not None:
                    bound = bound + other.bound
                    finding = replace(finding, times=np.fmax(finding.times, other.times), about=np.nan)
                found[key] = replace(finding, bound=bound)
            more = sum((np.fmax(finding.bound, 0.0) for finding in findings), start=np.zeros(np.shape(value)))
            values[place] = value + np.where(np.isfinite(more), more, 0.0)
    return tuple(found.values())


def capitalized(sentence: str) -> str:
    """The sentence with a capital first letter."""
    return sentence[:1].upper() + sentence[1:]
