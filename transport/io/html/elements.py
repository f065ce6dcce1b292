"""The HTML elements of all notebook output: a frame with its style, tables, warnings, folded sections.

Colours come from the page that contains the HTML, or are half transparent, so that light and dark themes both
work.
"""

from __future__ import annotations

import html
import re
from collections.abc import Iterable, Sequence

# ---- The library's text as HTML, with typographic minus signs, powers of ten and exponents.

_POWER_OF_TEN = re.compile(r"(?<=[\d)])e([+-]\d+)")
_MINUS = re.compile(r"(?<![\w.)])-(?=[\d.]|inf)")
_EXPONENT = re.compile(r"(?<=[A-Za-z])\^(?:\((-?\d+/\d+)\)|(-?\d+))")
_RAISED = str.maketrans("-0123456789/", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹⸍")


def escaped(text: object) -> str:
    """Any text as HTML with special characters escaped: a name may be "<b>"."""
    return html.escape(str(text), quote=True)


def typeset(text: object) -> str:
    """Text with numbers and units, such as "(2.0 ± 0.3)e-09 W m^-2", as HTML."""
    html = _POWER_OF_TEN.sub(lambda hit: f"\u00a0×\u00a010<sup>{_minus(int(hit[1]))}</sup>", escaped(text))
    html = _EXPONENT.sub(lambda hit: f"<sup>{_minus(hit[1] or hit[2])}</sup>", html)
    return _MINUS.sub("−", html)


def plain_typeset(text: object) -> str:
    """Typeset without HTML elements: exponents are superscript characters."""
    plain = _POWER_OF_TEN.sub(lambda hit: f"\u00a0×\u00a010{_raised(int(hit[1]))}", escaped(text))
    plain = _EXPONENT.sub(lambda hit: _raised(hit[1] or hit[2]), plain)
    return _MINUS.sub("−", plain)


def _minus(number: object) -> str:
    return str(number).replace("-", "−")


def _raised(number: object) -> str:
    return str(number).translate(_RAISED)


# ---- Elements.

STYLE = (
    "<style>"
    "div.tp{font-size:13px;line-height:1.45;color:inherit;max-width:72em;font-variant-numeric:tabular-nums}"
    ".tp.tp.tp table{border-collapse:collapse;border:0;margin:.25em 0 .5em;color:inherit;font-size:inherit;"
    "width:auto}"
    ".tp.tp.tp table tr:nth-child(n){background:none;border:0}"
    ".tp.tp.tp table td,.tp.tp.tp table th{padding:.16em .9em .16em 0;border:0;"
    "border-bottom:1px solid rgba(128,128,128,.25);"
    "text-align:left;vertical-align:middle;white-space:normal;color:inherit;background:none}"
    ".tp.tp.tp table th{font-weight:600}"
    ".tp.tp.tp table td.tp-n,.tp.tp.tp table th.tp-n{text-align:right;white-space:nowrap}"
    ".tp.tp.tp table tr.tp-best td{font-weight:600}"
    "div.tp sup{font-size:.72em;line-height:0}"
    "div.tp .tp-m{opacity:.66;font-weight:400}"
    "div.tp .tp-k{font-family:var(--jp-code-font-family,ui-monospace,Menlo,Consolas,monospace);"
    "font-size:.93em}"
    "div.tp .tp-h{font-weight:600;margin:.1em 0}"
    "div.tp .tp-w{border-left:3px solid #d08700;background:rgba(208,135,0,.13);padding:.3em .7em;"
    "margin:.3em 0}"
    "div.tp .tp-r{display:flex;flex-wrap:wrap;gap:.4em 2.2em;align-items:flex-start}"
    "div.tp details{margin:.15em 0}div.tp summary{cursor:pointer}"
    "div.tp img{display:block;max-width:100%;margin:.3em 0}"
    "</style>"
)


def framed(*parts: str) -> str:
    """The complete HTML that a notebook shows."""
    return f'<div class="tp">{STYLE}{"".join(parts)}</div>'


def heading(words: str, beside: str = "") -> str:
    """A line in bold; beside: HTML in grey after it."""
    return f'<div class="tp-h">{words}{f" {muted(beside)}" if beside else ""}</div>'


def muted(inner: str) -> str:
    """HTML in grey."""
    return f'<span class="tp-m">{inner}</span>'


def code(text: object) -> str:
    """A name in the font of code."""
    return f'<span class="tp-k">{escaped(text)}</span>'


def warning_boxes(warnings: Iterable[str]) -> str:
    """Each warning in its own box."""
    return "".join(f'<div class="tp-w"><b>warning</b> {escaped(text)}</div>' for text in warnings)


def table(rows: Iterable[Sequence[str]], heads: Sequence[str] = (), best: int | None = None) -> str:
    """Rows of cells of HTML; a cell that begins with ">" is a number, right-aligned.

    best: index of the bold row.
    """
    head = f"<thead><tr>{_cells('th', heads)}</tr></thead>" if heads else ""
    body = "".join(
        f"<tr{_class('tp-best') if place == best else ''}>{_cells('td', row)}</tr>"
        for place, row in enumerate(rows)
    )
    return f"<table>{head}<tbody>{body}</tbody></table>"


def details(summary: str, inner: str, is_open: bool) -> str:
    """A folded section, open at first if `is_open`."""
    return f"<details{' open' if is_open else ''}><summary>{summary}</summary>{inner}</details>"


def side_by_side(*parts: str) -> str:
    """Parts side by side, if there is room."""
    return '<div class="tp-r">' + "".join(f"<div>{part}</div>" for part in parts if part) + "</div>"


def _cells(tag: str, cells: Sequence[str]) -> str:
    return "".join(
        f"<{tag}{_class('tp-n')}>{cell[1:]}</{tag}>" if cell.startswith(">") else f"<{tag}>{cell}</{tag}>"
        for cell in cells
    )


def _class(name: str) -> str:
    return f' class="{name}"'
