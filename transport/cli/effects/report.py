"""Report of `transport effects`: compilation, memory, cost of effects and of possible additions."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict

from rich.table import Table

from transport.cli.console import print_json, print_labelled, print_rich
from transport.cli.effects.compile_times import CompileTime, cold_compile_time, compile_time_of
from transport.cli.effects.costs import (
    EFFECTS,
    EffectCost,
    Footprint,
    costs_by_effect,
    effect_of,
    files_of_passes,
    footprint_of,
    lanes_per_history,
)
from transport.cli.effects.passes import Effects, measure_passes
from transport.cli.effects.prices import UNCHANGED, Price, PriceList, base_prices, prices_in
from transport.cli.effects.treatment import Treatment
from transport.cli.tables import effect_table, effects_lines, pass_table, table_of
from transport.run.progress import open_progress
from transport.statistics.notation import duration

# ---- Tables and lines on effects: memory, compilation, and prices of additional effects.

PRICE_HEADS = (
    "effect", "over", "ns per history>", "adds ns>", "times>", "events>", "ns per event>", "passes>",
    "bytes per lane>",
)  # fmt: skip
COLD_HEADS = "kind of scene", "passes>", "cold>", "from disk>", "machine code>", "bytes per lane>", "carried>"


def price_table(prices: Iterable[Price]) -> Table:
    """Return a table with a row per price; `over` is empty for additions to the unchanged scene."""
    rows = []
    for price in prices:
        over = "" if price.over in (None, UNCHANGED) else price.over
        added = ("", "") if price.over is None else (f"{price.added:+.3g}", f"{price.ratio:.2f}")
        each = f"{price.ns_an_event:.3g}" if price.events else "–"
        sizes = str(price.passes), str(price.footprint.touched)
        rows.append([price.name, over, f"{price.ns:.3g}", *added, f"{price.events:.3g}", each, *sizes])
    return table_of(PRICE_HEADS, rows)


def price_lines(prices: PriceList) -> list[tuple[str, str]]:
    """Return (label, text) lines that explain the table and list the omitted additions."""
    note = "CPU time per history, medians of alternating runs; an event is a crossing or a collision"
    lines = [("note", note)]
    if any(price.over not in (None, UNCHANGED) for price in prices.prices):
        note = "an effect with an entry under over is compared with a run that has that effect alone"
        lines.append(("note", note))
    if prices.idle:
        lines.append(("no change", f"present already, or without effect: {', '.join(prices.idle)}"))
    if prices.refused:
        lines.append(("refused", f"impossible in this scene: {', '.join(dict.fromkeys(prices.refused))}"))
    return lines


def memory_line(footprint: Footprint) -> str:
    """Return a line on the bytes per lane and per bundle."""
    return (
        f"a step touches {footprint.touched} bytes per lane and carries {footprint.carried} with a"
        f" particle; a bundle uses {footprint.used / 1024:.0f} of {footprint.bundle / 1024:.0f} KiB, which"
        f" reserve {footprint.known} bytes per lane for all effects"
    )


def start_line(start: CompileTime) -> str:
    """Return a line on how many passes were compiled and how many loaded."""
    new = start.passes - start.on_disk
    if new == 0:
        return f"nothing: all {start.passes} passes were on disk, loaded in {duration(start.seconds)}"
    return (
        f"{new} of {start.passes} passes in {duration(start.seconds)}; {start.on_disk} were on disk already"
    )


def cold_table(starts: Mapping[str, tuple[CompileTime, CompileTime, Footprint]]) -> Table:
    """Return a table of the first start (empty cache) and the second start of each kind of scene."""
    rows = []
    for name, (first, second, footprint) in starts.items():
        times = duration(first.seconds), duration(second.seconds)
        sizes = f"{first.bytes / 2**20:.1f} MiB", str(footprint.touched), str(footprint.carried)
        rows.append([name, str(first.passes), *times, *sizes])
    return table_of(COLD_HEADS, rows)


# ---- The report.


def print_effects(effects: Effects, scene: Treatment, cold: bool, more: bool) -> None:
    """Print the used fields and the absent effects of a scene, then measure and print compilation and costs.

    `cold` also measures compilation with an empty cache; `more` also prices each effect that the scene lacks.
    """
    for label, names in (*effects_lines(effects)[:2], ("absent", absent_line(effects))):
        print_labelled(label, names)
    print_labelled("memory", memory_line(footprint_of(scene.program)))
    print_labelled("compiled", start_line(compile_with_progress(scene)))
    if cold:
        first = cold_compile_time(scene)
        print_labelled("cold", f"{duration(first.seconds)} for {first.passes} passes, with an empty cache")
    costs = measure_passes(scene)
    for number, births in enumerate(effects.births):
        print_rich(f"\nbirths at emitter {number}", style="bold")
        print_rich(pass_table(births, costs))
    print_rich("\nevery step", style="bold")
    print_rich(pass_table(effects.steps, costs))
    print_rich("\ncost of each effect", style="bold")
    print_rich(effect_table(_effect_costs(scene, costs)))
    if more:
        found = prices_in(scene)
        print_rich("\ncost of one additional effect", style="bold")
        _print_prices(found)


def absent_line(effects: Effects) -> str:
    """Return the names of the absent effects, and the numbers of absent passes and fields."""
    files, kinds = files_of_passes(), list(effects.absent.values())
    present = {effect_of(name, files) for name in effects.passes}
    absent = [name for name in EFFECTS if name not in present]
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
    start = compile_with_progress(scene)
    found = prices_in(scene) if more else None
    return {
        "memory": asdict(footprint_of(scene.program)),
        "compiled": asdict(start),
        "cold": asdict(cold_compile_time(scene)) if cold else None,
        "effects": [asdict(effect) for effect in _effect_costs(scene, costs)],
        "additions": None if found is None else [price.record for price in found.prices],
        "refused": None if found is None else dict(found.refused),
        "idle": None if found is None else list(found.idle),
    }


def print_base_prices(turns: int, json: bool) -> None:
    """Measure and print the price list of the base room."""
    found = base_prices(turns)
    if json:
        print_json([price.record for price in found.prices])
    else:
        _print_prices(found)


def _print_prices(found: PriceList) -> None:
    print_rich(price_table(found.prices))
    for label, text in price_lines(found):
        print_labelled(label, text)


def print_cold_starts(json: bool) -> None:
    """Measure and print compilation times of each kind of scene with an empty cache, and bytes per lane."""
    from transport.cli.bench.compile_times import compile_time_rows, compile_times

    starts = compile_times()
    print_json(compile_time_rows(starts)) if json else print_rich(cold_table(starts))


def compile_with_progress(scene: Treatment) -> CompileTime:
    """Compile or load the scene's program, with a progress bar."""
    with open_progress(None) as bar:
        return compile_time_of(scene, bar.compiling)


def _effect_costs(scene: Treatment, costs: Mapping[str, float]) -> list[EffectCost]:
    return costs_by_effect(costs, lanes_per_history(scene), files_of_passes()) if costs else []
