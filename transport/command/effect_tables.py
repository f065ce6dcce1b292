"""Tables of effects: what a program weighs and took to compile, and what each effect more would cost."""

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
    "ns a history>",
    "adds ns>",
    "times>",
    "events>",
    "ns an event>",
    "passes>",
    "bytes a lane>",
)
COLD_HEADS = "kind of scene", "passes>", "cold>", "from disk>", "machine code>", "bytes a lane>", "carried>"


def price_table(prices: Iterable[Price]) -> Table:
    """A line each, with what it is told over where that is not the scene as it is."""
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
    """(label, text): what the table means, and what is not in it."""
    lines = [
        (
            "note",
            "CPU time of a history, medians of runs taken in turns; an event is a crossing or a collision",
        )
    ]
    if any(price.over not in (None, AS_IT_IS) for price in prices.prices):
        lines.append(
            (
                "note",
                "what needs another effect is told over that: a run with both against a run with it alone",
            )
        )
    if prices.idle:
        lines.append(("no change", f"there already, or nothing to do: {', '.join(prices.idle)}"))
    if prices.refused:
        lines.append(("refused", f"does not go with this scene: {', '.join(dict.fromkeys(prices.refused))}"))
    return lines


def memory_line(footprint: Footprint) -> str:
    """Bytes of a lane and of a bundle."""
    return (
        f"{footprint.touched} bytes of a lane are touched in a step, {footprint.carried} move along with a particle; a bundle"
        f" uses {footprint.used / 1024:.0f} KiB of {footprint.bundle / 1024:.0f}, in which {footprint.known} bytes a lane"
        " are reserved for all effects"
    )


def start_line(start: Start) -> str:
    """What was compiled, and what came from disk."""
    new = start.passes - start.on_disk
    if new == 0:
        return f"nothing: all {start.passes} passes were on disk, and loaded in {duration(start.seconds)}"
    return (
        f"{new} of {start.passes} passes in {duration(start.seconds)}; {start.on_disk} were on disk already"
    )


def cold_table(starts: Mapping[str, tuple[Start, Start, Footprint]]) -> Table:
    """The first start of kinds of scenes, with nothing on disk, and the second, each in a new process."""
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
