"""Report of `transport effects`: compilation, memory, cost of effects and of possible additions."""

from collections.abc import Mapping
from dataclasses import asdict

from transport.command.cold_start import Start, cold_start, start_of
from transport.command.console import say, say_json, say_labelled
from transport.command.effect_costs import EFFECTS, EffectCost, files_of_passes, grouped, plain_name
from transport.command.effect_prices import base_prices, prices_in
from transport.command.effect_tables import cold_table, memory_line, price_lines, price_table, start_line
from transport.command.effects import Effects, costs_of
from transport.command.footprints import footprint_of
from transport.command.pass_costs import lanes_a_history
from transport.command.tables import effect_table, effects_lines, pass_table
from transport.command.treatment import Treatment
from transport.results.notation import duration
from transport.runs.progress import progress_on


def print_effects(told: Effects, scene: Treatment, cold: bool, more: bool) -> None:
    """Print the used fields and the absent effects of a scene, then measure and print compilation and costs.

    `cold` also measures compilation with an empty cache; `more` also prices each effect that the scene lacks.
    """
    for label, names in (*effects_lines(told)[:2], ("absent", absent_line(told))):
        say_labelled(label, names)
    say_labelled("memory", memory_line(_footprint(scene)))
    say_labelled("compiled", start_line(started(scene)))
    if cold:
        first = cold_start(scene)
        say_labelled("cold", f"{duration(first.seconds)} for {first.passes} passes, with an empty cache")
    costs = costs_of(scene)
    for number, births in enumerate(told.births):
        say(f"\nbirths at emitter {number}", style="bold")
        say(pass_table(births, costs))
    say("\nevery step", style="bold")
    say(pass_table(told.steps, costs))
    say("\ncost of each effect", style="bold")
    say(effect_table(_shares(scene, costs)))
    if more:
        found = prices_in(scene)
        say("\ncost of one additional effect", style="bold")
        say(price_table(found.prices))
        for label, text in price_lines(found):
            say_labelled(label, text)


def absent_line(told: Effects) -> str:
    """Return the names of the absent effects, and the numbers of absent passes and fields."""
    files, kinds = files_of_passes(), list(told.absent.values())
    present = {files.get(plain_name(name)) for name in told.passes}
    absent = [name for name, members in EFFECTS.items() if not present & set(members)]
    return (
        f"{', '.join(absent)}; in all {kinds.count('pass')} passes and {kinds.count('field')} fields"
        " of the engine (--json lists them)"
    )


def record_of_scene(
    scene: Treatment, costs: Mapping[str, float], cold: bool, more: bool
) -> dict[str, object]:
    """Return {memory, compiled, cold, effects, additions, refused, idle} of one scene for JSON.

    `cold` and the entries on additions are None if not requested.
    """
    start = started(scene)
    found = prices_in(scene) if more else None
    return {
        "memory": asdict(_footprint(scene)),
        "compiled": asdict(start),
        "cold": asdict(cold_start(scene)) if cold else None,
        "effects": [asdict(effect) for effect in _shares(scene, costs)],
        "additions": None if found is None else [price.record for price in found.prices],
        "refused": None if found is None else dict(found.refused),
        "idle": None if found is None else list(found.idle),
    }


def print_base_prices(turns: int, json: bool) -> None:
    """Measure and print the price list of the base room."""
    found = base_prices(turns)
    if json:
        say_json([price.record for price in found.prices])
        return
    say(price_table(found.prices))
    for label, text in price_lines(found):
        say_labelled(label, text)


def print_cold_starts(json: bool) -> None:
    """Measure and print compilation times of each kind of scene with an empty cache, and bytes per lane."""
    from transport.command.cold_bench import cold_rows, cold_starts

    starts = cold_starts()
    say_json(cold_rows(starts)) if json else say(cold_table(starts))


def started(scene: Treatment) -> Start:
    """Compile or load the scene's program, with a progress bar."""
    with progress_on(None) as bar:
        return start_of(scene, bar.compiling)


def _shares(scene: Treatment, costs: Mapping[str, float]) -> list[EffectCost]:
    return grouped(costs, lanes_a_history(scene), files_of_passes()) if costs else []


def _footprint(scene: Treatment):
    from transport.engine.program import program_of

    return footprint_of(program_of(scene.plan))
