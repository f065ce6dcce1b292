"""Tables and lines on effects: memory, compilation, and prices of additional effects."""

from collections.abc import Iterable, Mapping

from rich.table import Table

from transport.command.cold_start import Start
from transport.command.effect_prices import AS_IT_IS, Price, PriceList
from transport.command.footprints import Footprint
from transport.command.tables import plain_table
from transport.results.notation import duration

PRICE_HEADS = (
    "effect",
    "over",
    "ns per history>",
    "adds ns>",
    "times>",
    "events>",
    "ns per event>",
    "passes>",
    "bytes per lane>",
)
COLD_HEADS = "kind of scene", "passes>", "cold>", "from disk>", "machine code>", "bytes per lane>", "carried>"


def price_table(prices: Iterable[Price]) -> Table:
    """Return a table with a row per price; `over` is empty for additions to the unchanged scene."""
    table = plain_table(*PRICE_HEADS)
    for price in prices:
        of_scene = price.over is None
        table.add_row(
            price.name,
            "" if of_scene or price.over == AS_IT_IS else price.over,
            f"{price.ns:.3g}",
            "" if of_scene else f"{price.added:+.3g}",
            "" if of_scene else f"{price.ratio:.2f}",
            f"{price.events:.3g}",
            f"{price.ns_an_event:.3g}" if price.events else "–",
            str(price.passes),
            str(price.footprint.touched),
        )
    return table


def price_lines(prices: PriceList) -> list[tuple[str, str]]:
    """Return (label, text) lines that explain the table and list the omitted additions."""
    lines = [
        (
            "note",
            "CPU time per history, medians of alternating runs; an event is a crossing or a collision",
        )
    ]
    if any(price.over not in (None, AS_IT_IS) for price in prices.prices):
        lines.append(
            (
                "note",
                "an effect with an entry under over is compared with a run that has that effect alone",
            )
        )
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


def start_line(start: Start) -> str:
    """Return a line on how many passes were compiled and how many loaded."""
    new = start.passes - start.on_disk
    if new == 0:
        return f"nothing: all {start.passes} passes were on disk, loaded in {duration(start.seconds)}"
    return (
        f"{new} of {start.passes} passes in {duration(start.seconds)}; {start.on_disk} were on disk already"
    )


def cold_table(starts: Mapping[str, tuple[Start, Start, Footprint]]) -> Table:
    """Return a table of the first start (empty cache) and the second start of each kind of scene."""
    table = plain_table(*COLD_HEADS)
    for name, (first, second, footprint) in starts.items():
        table.add_row(
            name,
            str(first.passes),
            duration(first.seconds),
            duration(second.seconds),
            f"{first.bytes / 2**20:.1f} MiB",
            str(footprint.touched),
            str(footprint.carried),
        )
    return table
