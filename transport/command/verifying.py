"""`transport verify`: runs experiments and judges their laws together."""

from types import ModuleType

from transport.command.console import say, say_json, status_of
from transport.command.running import checked, is_complete
from transport.command.tables import law_tables
from transport.command.verify import FALSE_ALARM, POWER, Law, laws_of
from transport.experiment import Outcome, experiment, experiment_names, outcomes_of
from transport.hard.cases import families
from transport.validation import SceneError


def verify_laws(sims: list[str] | None, limits: dict[str, object], json: bool) -> int:
    """Run these experiments, or all, and print their laws.

    Returns status 1 if one fails, 130 if interrupted.
    """
    laws, complete = [], True
    for module in modules_of(sims):
        outcomes, complete = known_outcomes(module, limits)
        laws += laws_of(module, outcomes)
        if not complete:
            break
    check_any(laws, complete)
    rate = FALSE_ALARM / len(laws)
    failed = sum(not law.holds(rate) for law in laws)
    if json:
        say_json([law_record(law, rate) for law in laws])
    else:
        say(*law_tables(laws, rate))
        say(f"{len(laws) - failed} of {len(laws)} rows hold", style="bold red" if failed else "bold green")
        say(
            f"false alarms: {FALSE_ALARM:g} over all rows; smallest bias: relative, detected with {POWER:.0%}"
            " power"
        )
    return status_of(failed, complete)


def modules_of(sims: list[str] | None) -> list[ModuleType]:
    """Return these experiments, or all.  Raises SceneError for an unknown name before anything runs."""
    for name in sims or ():
        if name in families():
            raise SceneError(
                f"verify: {name!r} is a family of hard cases, not an experiment;"
                f" write transport verify --hard {name}"
            )
    return [checked(experiment(name)) for name in sims or experiment_names()]


def known_outcomes(module: ModuleType, limits: dict[str, object]) -> tuple[list[Outcome], bool]:
    """Run the experiment's cases until Ctrl-C; return the outcomes so far, and whether they are complete."""
    outcomes = []
    try:
        for outcome in outcomes_of(module, {}, limits):
            outcomes.append(outcome)
    except KeyboardInterrupt:
        return outcomes, False
    return outcomes, is_complete(outcomes)


def check_any(laws: list[Law], complete: bool) -> None:
    """Raise SceneError if there are no laws, KeyboardInterrupt if interrupted before the first."""
    if laws:
        return
    if not complete:
        raise KeyboardInterrupt
    raise SceneError("verify: nothing to judge; name an experiment or .py file with exact values")


def law_record(law: Law, rate: float) -> dict[str, object]:
    """Return a row for JSON; `rate` is the false-alarm rate of the test."""
    return {
        "law": law.law,
        "source": law.source,
        "sim": law.sim,
        "quantity": law.quantity,
        "value": law.estimate.value,
        "error": law.estimate.error,
        "unit": str(law.estimate.unit),
        "exact": law.exact,
        "z": law.z,
        "smallest_bias": law.smallest_bias(rate),
        "holds": law.holds(rate),
    }
