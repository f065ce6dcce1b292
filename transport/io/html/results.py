"""The result of a run in a notebook: warnings first, then energy balance, detectors and cost."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from transport.io.html.elements import details, escaped, framed, heading, muted, table, typeset, warning_boxes
from transport.io.html.estimates import reading_parts
from transport.results.report import (
    cost_lines,
    error_bar_line,
    ledger_title,
    method_lines,
    price_lines,
    printed_entries,
    run_line,
    tracking_lines,
)
from transport.scene.phase_space import Snapshot

if TYPE_CHECKING:
    from transport.results.result import Ledger, Result

MAX_UNFOLDED_DETECTORS = 2  # number of detectors up to which they are shown unfolded, with pictures


def result_html(result: Result) -> str:
    """The contents of `result.report()` as HTML."""
    warnings = result.warnings
    how = [*method_lines(result), *tracking_lines(result)]
    detectors = result.scene.detectors
    return framed(
        heading("Result", escaped(run_line(result))),
        warning_boxes(warnings),
        *(f"<div>{typeset(line)}</div>" for line in how),
        details(escaped(ledger_title(result)), ledger_table(result._own_ledger), True),
        *(
            _detector_section(result, detector, len(detectors) <= MAX_UNFOLDED_DETECTORS)
            for detector in detectors
        ),
        *(f"<div>{muted(typeset(line))}</div>" for line in cost_lines(result)),
        "" if warnings else f"<div>{muted(typeset(error_bar_line(result)))}</div>",
    )


def ledger_html(ledger: Ledger) -> str:
    """The energy balance alone."""
    return framed(heading("Ledger"), ledger_table(ledger))


def ledger_table(ledger: Ledger) -> str:
    """A row per entry, with its share of the emitted power."""
    emitted = ledger["emitted"].value
    return table(
        [
            ("&emsp;" if is_part else "") + escaped(name),
            f"<span>{typeset(estimate)}</span>",
            _share_cell(estimate.value / emitted if emitted else math.nan),
        ]
        for name, estimate, is_part in printed_entries(ledger)
    )


def _detector_section(result: Result, detector: object, is_open: bool) -> str:
    reading = result[detector.name]
    title = f"<b>{escaped(reading.heading)}</b>"
    if isinstance(detector, Snapshot):
        return f"<div>{title}</div>"
    prices = "".join(f"<div>{muted(typeset(line))}</div>" for line in price_lines(result, detector.name))
    return details(title, reading_parts(reading, has_picture=is_open) + prices, is_open)


def _share_cell(share: float) -> str:
    """A share of the whole in percent; empty if there is none."""
    return ">" + muted(f"{100 * share:.3g} %") if 0 <= share <= 1 else ""
