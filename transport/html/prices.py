"""The cost of accuracy in a notebook: a row per estimator, the cheapest in bold."""

from __future__ import annotations

from typing import TYPE_CHECKING

from transport.html.elements import framed, heading, muted, table
from transport.html.typesetting import escaped, typeset
from transport.pricing.price_table import price_heads, price_notes, price_rows, price_title

if TYPE_CHECKING:
    from transport.pricing.cost import CostOfAccuracy


def prices_html(cost: CostOfAccuracy) -> str:
    """The same rows and notes as in the object's text."""
    heads = [f">{typeset(h.rstrip('>'))}" if h.endswith(">") else escaped(h) for h in price_heads(cost)]
    rows = [[escaped(row[0]), *(f">{typeset(cell)}" for cell in row[1:])] for row in price_rows(cost)]
    names = [way.name for way in cost.ways]
    best = names.index(cost.cheapest.name) if cost.cheapest is not None else None
    notes = (f"<div>{muted(typeset(note))}</div>" for note in price_notes(cost))
    return framed(heading(typeset(price_title(cost))), table(rows, heads, best), *notes)
