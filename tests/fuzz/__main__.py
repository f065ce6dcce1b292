"""The long fuzz: `python -m tests.fuzz --scenes 1000 --seed 0` makes so many scenes, checks them and prints what came of it.

Each scene is known by (seed, number) and printed as Python where something did not hold.  One that takes longer than the limit
is counted as slow: whether it would hold, or ever end, is not known; run it alone with a larger --limit to see.
"""

from __future__ import annotations

import sys
from collections import Counter

import typer

from tests.fuzz.numbered import FAMILIES, Outcome, outcomes_of


def main(
    scenes: int = 1000,
    seed: int = 0,
    first: int = typer.Option(0, help="Number of the first scene"),
    limit: float = typer.Option(120.0, help="Seconds of processor time that a scene may take"),
) -> None:
    """Run the scenes; exit with 1 if anything failed or was too slow."""
    outcomes = []
    for outcome in outcomes_of(range(first, first + scenes), seed, limit):
        outcomes.append(outcome)
        if fault := outcome.failed or outcome.slow:
            print(f"\n# scene {outcome.number} of seed {seed}, {outcome.family}: {fault}")
            print(outcome.snippet, flush=True)
        if len(outcomes) % 100 == 0:
            print(f"{len(outcomes)} scenes", file=sys.stderr)
    print(summary_of(outcomes, seed))
    raise typer.Exit(any(outcome.failed or outcome.slow for outcome in outcomes))


def summary_of(outcomes: list[Outcome], seed: int) -> str:
    """Scenes, refusals, checks, failures and those without an end by family, and what was refused most."""
    lines = [
        f"\n{len(outcomes)} scenes of seed {seed}",
        f"{'family':10}{'scenes':>8}{'refused':>9}{'checks':>8}{'failed':>8}{'slow':>6}",
    ]
    for family in FAMILIES:
        of_it = [outcome for outcome in outcomes if outcome.family == family]
        refused, failed, slow = (
            sum(bool(getattr(o, name)) for o in of_it) for name in ("refused", "failed", "slow")
        )
        checks = sum(o.checks for o in of_it)
        lines.append(f"{family:10}{len(of_it):8}{refused:9}{checks:8}{failed:8}{slow:6}")
    refusals = Counter(" ".join(outcome.refused.split()[:8]) for outcome in outcomes if outcome.refused)
    lines += [f"refused {count} times: {words} ..." for words, count in refusals.most_common(8)]
    slowest = max(outcomes, key=lambda outcome: outcome.seconds)
    lines.append(f"slowest: scene {slowest.number}, {slowest.seconds:.1f} s with what it compiled")
    failed = [str(outcome.number) for outcome in outcomes if outcome.failed]
    slow = [str(outcome.number) for outcome in outcomes if outcome.slow]
    lines.append(f"slow: {', '.join(slow) or 'none'}")
    return "\n".join([*lines, f"failed: {', '.join(failed) or 'none'}"])


if __name__ == "__main__":
    typer.run(main)
