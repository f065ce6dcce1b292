"""The experiments: each module a short paper with derivation, scene, exact values and figure.

What they have in common is described in transport/verification/experiment.py.  `python -m transport.sims.sun` runs one and prints its table, and
`transport run sun` does so with its picture.
"""

from __future__ import annotations

if __name__ == "sims":
    raise ImportError("'sims' is a part of transport now: import transport.sims")

import numpy as np

from transport import Estimate, Result
from transport.verification.experiment import Outcome, experiment, run_experiment

ROUNDING = 1e-12  # of the terms of a difference: what is smaller is left over from their cancellation


def constant(result: Result, value: float, unit: str) -> Estimate:
    """A known number with its unit, to calculate with the estimates of a run."""
    return Estimate(np.full(len(result.run), value), result.run, unit, exact=True)


def sharp(estimate: Estimate, of: Estimate) -> Estimate:
    """The estimate, labelled exact where its batches differ by no more than the rounding of `of`.

    For what is the same in every history although it is calculated from random sums; what the cancellation of sums of
    the size of `of` leaves is 0 then.
    """
    rounding = ROUNDING * abs(of.value)
    if not np.ptp(estimate.values) <= rounding:
        return estimate
    value = 0.0 if abs(estimate.value) <= rounding else estimate.value
    return Estimate(np.full(len(estimate.run), value), estimate.run, estimate.unit, exact=True)


def provenance(outcomes: list[Outcome]) -> str:
    """Particles and seed of the runs, for the small print of a figure."""
    particles, seed = max(o.result.particles for o in outcomes), outcomes[0].result.seed
    return f"{particles:_} particles a case, seed {seed}"


def print_table(path: str) -> None:
    """Run the experiment of this file and print its tables and its verdict."""
    module = experiment(path)
    outcomes = run_experiment(module)
    print(module.law)
    for outcome in outcomes:
        print(f"\n{outcome.title}")
        for row in outcome.rows:
            print(f"  {row.name:42s} {row.estimate!s:46s} exact {row.exact:<12.6g} z {row.z:+.2f}")
    print(f"\n{module.verdict(outcomes)}")


def furthest(outcomes: list[Outcome]) -> str:
    """How far off the worst of all readings is, in words for a verdict."""
    rows = [row for outcome in outcomes for row in outcome.rows]
    scores = [abs(row.z) for row in rows if np.isfinite(row.z)]
    if not scores:
        return "no reading has an error bar"
    if len(rows) == 1:
        return f"{scores[0]:.1f} standard errors off"
    return f"the furthest of {len(rows)} readings is {max(scores):.1f} standard errors off"


def draw_rows(outcomes: list[Outcome], path: str, title: str) -> None:
    """Every reading of every case beside its exact value."""
    from transport.viz.comparisons import comparison

    table = {
        "\n".join(filter(None, (row.name, o.title))): (row.estimate, row.exact)
        for o in outcomes
        for row in o.rows
    }
    comparison(table, path, title=title, note=provenance(outcomes))
