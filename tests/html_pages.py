"""Objects' HTML taken apart: its tags, which must close in order, and what it says."""

import re
from html.parser import HTMLParser

import numpy as np

from tests.synthetic import estimates

VOID = {"br", "img", "hr"}


class Page(HTMLParser):
    """The tags of a piece of HTML, checked to close in order, and the text between them."""

    def __init__(self, html):
        super().__init__(convert_charrefs=True)
        self.open, self.tags, self.attributes, self.said, self.styles = [], [], [], "", []
        self.feed(html)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        names = [name for name, _ in attributes]
        assert len(set(names)) == len(names)
        self.tags.append(tag)
        self.attributes.append(dict(attributes))
        if tag not in VOID:
            self.open.append(tag)
        if tag == "sup":
            self.said += "^" if self.said[-1:].isalpha() else ""

    def handle_startendtag(self, tag, attributes):
        self.tags.append(tag)
        self.attributes.append(dict(attributes))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag
        self.said += "\n" if tag in ("td", "th", "div", "summary") else ""

    def handle_data(self, data):
        if self.open[-1:] == ["style"]:
            self.styles.append(data)
        else:
            self.said += data.replace("−", "-")

    @property
    def text(self):
        """What it says in the notation of the project's text."""
        said = re.sub(r"\^(-?\d+/\d+)", r"^(\1)", self.said)
        return re.sub(r"\xa0×\xa010(-?)(\d+)", lambda hit: f"e{hit[1] or '+'}{int(hit[2]):02d}", said)


def page(thing):
    return Page(thing._repr_html_())


def column(values, name="x", edges=None, **options):
    """An array along one axis of which the batches all but agree."""
    edges = np.linspace(0, 1, len(values) + 1) if edges is None else edges
    return estimates(values, (name,), (edges,), "W m^-2", 0.01, **options)
