"""`transport docs`: README, guides, reference and help of the commands as HTML pages, built by Sphinx."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import inspect
import io
import re
import shutil
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import transport
from transport.results.backward import ViewReading
from transport.results.detectors import Reading
from transport.results.phase_space import PhaseReading, SnapshotReading
from transport.results.points import PointReading
from transport.results.record import Cost
from transport.results.result import Ledger
from transport.results.tally import Tally
from transport.results.volumes import VolumeReading
from transport.validation import SceneError, pip_install

# ---- Pages of the reference: every public name on the page of its module, with its docstring.

# SI units of the conversion factors, as in 650 * tp.nm
FACTORS = {"m": "nm um mm cm km au", "s": "ns us", "rad": "deg arcmin arcsec mrad"}
UNITS = {name: unit for unit, names in FACTORS.items() for name in names.split()}
UNITS["speed_of_light"] = "m s^-1"
PICTURES = (
    "plot_map", "plot_maps", "plot_curves", "curves.Series", "polar_curves", "comparison", "convergence",
    "power_flow", "phase_portraits", "figure", "scene.draw_scene",
)  # fmt: skip
RETURNED_CLASSES = (
    Reading, VolumeReading, PointReading, PhaseReading, SnapshotReading, Ledger, ViewReading, Cost,
)  # fmt: skip


@dataclass
class Page:
    """A page of the reference: its title, the modules that it covers, and their public names."""

    file: str
    title: str
    modules: tuple[str, ...]
    extra_classes: tuple[type, ...] = ()  # classes that results return
    pictures: tuple[str, ...] = ()  # names in transport.viz
    names: list[str] = field(default_factory=list)

    @property
    def text(self) -> str:
        """The page as MyST Markdown for Sphinx."""
        entries = [*map(_autodoc_entry, self.names), *map(_class_entry, self.extra_classes)]
        for name in (f"transport.viz.{name}" for name in self.pictures):
            kind = "class" if name.rpartition(".")[2].istitle() else "function"
            entries.append(f".. auto{kind}:: {name}")
        return f"# {self.title}\n\n```{{eval-rst}}\n{chr(10).join(entries)}\n```\n"


def pages() -> list[Page]:
    """Return the pages with all public names.  Raises LookupError for a name without a page."""
    sources = "scene.scene", "scene.sources", "scene.emissions", "scene.pulses", "validation"
    detectors = "scene.detectors", "scene.bins", "scene.cameras", "scene.volumes", "scene.points"
    analysis = "analysis.tracks", "analysis.solid_angle", "analysis.view_factors"
    found = [
        Page("scene", "Scenes and sources", sources),
        Page("shapes", "Shapes", ("geometry",)),
        Page("materials", "Surfaces and materials", ("scene.materials",)),
        Page("media", "Media", ("scene.media", "scene.phase_functions", "scene.tracking")),
        Page("speeds", "Speeds and phase space", ("scene.speeds", "scene.phase_space")),
        Page("detectors", "Detectors", detectors),
        Page("runs", "Runs", ("simulate", *analysis)),
        Page("results", "Results", ("results", "statistics"), RETURNED_CLASSES),
        Page("cost", "What accuracy costs", ("analysis.cost", "analysis.binning")),
        Page("units", "Units", ("units",)),
        Page("files", "Saved runs", ("io",)),
    ]
    for name in sorted(transport.__all__, key=str.lower):
        module = getattr(getattr(transport, name), "__module__", "transport.units")
        _page_of(module, name, found).names.append(name)
    if importlib.util.find_spec("matplotlib") is not None:
        found.append(Page("pictures", "Pictures", (), pictures=PICTURES))
    return found


def _page_of(module: str, name: str, found: list[Page]) -> Page:
    for page in found:
        if any(f"{module}.".startswith(f"transport.{known}.") for known in page.modules):
            return page
    raise LookupError(f"transport.{name} of {module} has no page: add its module to one")


def _autodoc_entry(name: str) -> str:
    value = getattr(transport, name)
    if isinstance(value, type):
        is_error = issubclass(value, BaseException)
        return f".. autoclass:: transport.{name}" + "\n   :no-inherited-members:" * is_error
    if callable(value):
        return f".. autofunction:: transport.{name}"
    return f".. py:data:: {name}\n   :value: {value!r} {UNITS[name]}"


def _class_entry(kind: type) -> str:
    """A class that results return; the quantities of a tally as a table, from their descriptors."""
    entry = f".. autoclass:: {kind.__module__}.{kind.__qualname__}"
    names = kind.known if issubclass(kind, Tally) else ()
    if not names:
        return entry
    table = [f".. list-table:: Quantities of `{kind.__name__}`"]
    table += ["   :header-rows: 1", "   :widths: 22 60 18", ""]
    rows = [("quantity", "meaning [unit]", "needs")]
    for name in names:
        quantity = getattr(kind, name)
        rows.append((f"`{name}`", inspect.cleandoc(quantity.__doc__), ", ".join(quantity.needs)))
    for row in rows:
        first, *others = (cell.replace("\n", "\n       ") for cell in row)
        table += [f"   * - {first}", *(f"     - {cell}".rstrip() for cell in others)]
    return "\n".join([entry, f"   :exclude-members: {', '.join(names)}", "", *table, ""])


def command_pages(group: Any) -> Iterator[tuple[str, str]]:
    """Yield the name of each command of a click group and the text of `transport NAME --help`."""
    for name, command in group.commands.items():
        context = command.make_context(name, [], parent=_root_context(group), resilient_parsing=True)
        yield name, command.get_help(context)


def _root_context(group):
    return group.make_context("transport", [], resilient_parsing=True)


# ---- The site.

PACKAGE = Path(__file__).resolve().parents[1]
GUIDES = PACKAGE / "guides"
SITE_CSS = """\
.content { width: 56em; }  /* code blocks have lines of 100 characters */
.sphinx-codeautolink-a:link { text-decoration: underline dotted; text-underline-offset: 0.2em; }
@media (max-width: 40em) {  /* pictures stay readable on a phone: they move under the finger */
  article p:has(> img) { overflow-x: auto; }
  article p > img { max-width: none; width: 38em; }
}
"""
REQUIRED_PACKAGES = ("sphinx", "furo", "myst_nb", "sphinx_codeautolink", "latex2mathml")
GUIDE_KINDS = {  # pages by kind, as the site lists them
    "Tutorials": ("room", "tissue", "tube"),
    "Course": ("course",),
    "How to": ("howto", "plots", "estimators"),
    "Explanations": ("numbers", "cost", "peers"),
    "Reference: scenes": ("surfaces", "media", "clocks", "cameras"),
    "Reference: runs and files": ("scenes", "saving", "clusters", "commands"),
    "Reference: figures and terms": ("gallery", "laws", "performance", "glossary"),
    "Development": ("extending", "code"),
}
GUIDE_ORDER = tuple(name for names in GUIDE_KINDS.values() for name in names)
CONTINUED = (*GUIDE_KINDS["Tutorials"], "gallery")  # pages whose blocks go on from one another


def build_site(out: Path, commands: Any) -> Path:
    """Build the pages into the folder; return the path of the first.  Raises SceneError without Sphinx."""
    missing = [name for name in REQUIRED_PACKAGES if importlib.util.find_spec(name) is None]
    if missing:
        raise SceneError(f"docs: {', '.join(missing)} not installed; {pip_install('docs')}")
    from sphinx.application import Sphinx

    with tempfile.TemporaryDirectory() as folder:
        sources, trees, made = (Path(folder) / name for name in ("sources", "trees", "site/html"))
        write_sources(sources, commands)
        output, warned = io.StringIO(), io.StringIO()
        site = Sphinx(sources, None, made, trees, "html", _sphinx_settings(), status=output, warning=warned)
        site.build()
        if site.statuscode or warned.getvalue().strip():
            raise SceneError(f"docs: Sphinx reports warnings: {warned.getvalue().strip()}")
        shutil.copytree(made, out, dirs_exist_ok=True)
    return out / "index.html"


def setup(app: Any) -> dict[str, Any]:
    """Connect the handlers below: this module is an extension of Sphinx."""
    app.connect("autodoc-skip-member", _is_internal)
    app.connect("autodoc-process-docstring", _without_flags)
    app.connect("doctree-read", _link_names)
    app.add_html_math_renderer("mathml", (_write_math, None), (_write_math, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def write_sources(folder: Path, commands: Any) -> None:
    """Write the sources of Sphinx: Markdown pages and their pictures."""
    (folder / "guides").mkdir(parents=True)
    (folder / "reference").mkdir()
    for page in pages():
        (folder / "reference" / f"{page.file}.md").write_text(page.text, encoding="utf-8")
    help_texts = "\n".join(
        f"## transport {name}\n\n```text\n{text}\n```\n" for name, text in command_pages(commands)
    )
    (folder / "reference" / "commands.md").write_text(f"# Commands\n\n{help_texts}", encoding="utf-8")
    for guide in sorted(GUIDES.glob("*.md")):
        text = guide.read_text(encoding="utf-8").replace("](../../viz/gallery/", "](../gallery/")
        (folder / "guides" / guide.name).write_text(text, encoding="utf-8")
    first = readme().replace("](viz/gallery/", "](gallery/").replace("](transport/guides/", "](guides/")
    notebooks = sorted(package_folder("sims", "notebooks").glob("*.ipynb"))
    for notebook in notebooks:
        shutil.copy(notebook, folder / "guides")
    contents = _contents([notebook.stem for notebook in notebooks])
    (folder / "index.md").write_text(first + contents, encoding="utf-8")
    (folder / "looks").mkdir()
    (folder / "looks" / "site.css").write_text(SITE_CSS)
    shutil.copytree(package_folder("viz", "gallery"), folder / "gallery")


def readme() -> str:
    """Return the README of the project's folder, or of the installed package."""
    beside = PACKAGE.parent / "README.md"
    if beside.is_file():
        return beside.read_text(encoding="utf-8")
    return str(importlib.metadata.metadata("transport").get_payload())


def package_folder(package: str, name: str) -> Path:
    """Return a folder of data of `sims` or `viz`, without an import of the package."""
    spec = importlib.util.find_spec(f"transport.{package}")
    assert spec is not None and spec.origin is not None
    return Path(spec.origin).parent / name


def _contents(notebooks: list[str]) -> str:
    kinds = {kind: [f"guides/{name}" for name in names] for kind, names in GUIDE_KINDS.items()}
    kinds["Tutorials"] += [f"guides/{name}" for name in notebooks]
    kinds["Reference: names"] = [f"reference/{page.file}" for page in pages()] + ["reference/commands"]
    return "".join(
        f"\n\n```{{toctree}}\n:hidden:\n:caption: {caption}\n\n{chr(10).join(files)}\n```\n"
        for caption, files in kinds.items()
    )


def _is_internal(app: Any, what: str, name: str, value: Any, skip: bool, options: Any) -> bool | None:
    """Leave out what base classes ask of their subclasses: their docstrings have no sections for users.

    A handler of Sphinx's event autodoc-skip-member; None leaves the decision to Sphinx.
    """
    function = getattr(value, "fget", value)
    module = sys.modules.get(getattr(function, "__module__", None))
    kind = getattr(module, getattr(function, "__qualname__", "").partition(".")[0], None)
    owners = [each for each in kind.__mro__ if name in vars(each)] if isinstance(kind, type) else []
    if not owners or not owners[-1].__subclasses__():
        return None
    doc = getattr(vars(owners[-1])[name], "__doc__", None) or ""
    return None if "\n---" in inspect.cleandoc(doc) else True


def _without_flags(app: Any, what: str, name: str, value: Any, options: Any, lines: list[str]) -> None:
    """Cut the flags of doctest off examples: a handler of Sphinx's event autodoc-process-docstring."""
    lines[:] = [re.sub(r"\s*# doctest: .*", "", line) for line in lines]


def _link_names(app: Any, doctree: Any) -> None:
    """Link each public name between backticks, as in `tp.Box(size=2.0)`, to its entry in the reference.

    A handler of Sphinx's event doctree-read.  The extension sphinx_codeautolink links blocks of code and
    lists at each entry the blocks that use it.
    """
    from docutils import nodes
    from sphinx.addnodes import pending_xref

    for literal in list(doctree.findall(nodes.literal)):
        name = re.match(r"(?:tp\.)?(\w+)(?=\(|$)", literal.astext())
        is_linked = isinstance(literal.parent, pending_xref | nodes.reference)
        if name and name[1] in transport.__all__ and not is_linked:
            target = f"transport.{name[1]}" if callable(getattr(transport, name[1])) else name[1]
            reference = pending_xref(
                refdomain="py", reftype="obj", reftarget=target, refexplicit=True, refdoc=app.env.docname
            )
            literal.replace_self(reference)
            reference += literal


def _write_math(writer: Any, node: Any) -> None:
    """Write a formula as MathML, which browsers draw without a script or a network."""
    from docutils.nodes import SkipNode, math_block
    from latex2mathml.converter import convert

    display = "block" if isinstance(node, math_block) else "inline"
    writer.body.append(convert(node.astext(), display=display))
    raise SkipNode


def _sphinx_settings() -> dict[str, object]:
    public = {name: getattr(transport, name) for name in transport.__all__}
    return {
        "project": "transport",
        "extensions": [
            "sphinx.ext.autodoc",
            "sphinx.ext.napoleon",
            "myst_nb",
            "sphinx_codeautolink",
            __name__,
        ],
        "myst_enable_extensions": ["dollarmath"],
        "nb_execution_mode": "off",  # the notebook keeps what it printed and drew
        "codeautolink_global_preface": "import transport as tp",
        "codeautolink_autodoc_inject": True,
        "codeautolink_inventory_map": {  # where a class is defined, and where it is documented
            f"{value.__module__}.{value.__qualname__}": f"transport.{name}"
            for name, value in public.items()
            if isinstance(value, type)
        },
        "napoleon_google_docstring": False,
        # Render sections as lists: otherwise words of a type such as "shape (n,)" become links, and an entry
        # under Attributes clashes with the member of that name.
        "napoleon_custom_sections": [("Attributes", "params_style")],
        "napoleon_use_param": False,
        "napoleon_use_rtype": False,
        "html_math_renderer": "mathml",
        "html_theme": "furo",
        "html_title": "transport",
        "html_show_sphinx": False,
        "html_show_copyright": False,
        "html_static_path": ["looks"],
        "html_css_files": ["site.css"],
        "html_copy_source": False,
        "default_role": "code",
        "autodoc_typehints_format": "short",
        "autodoc_member_order": "bysource",
        "autodoc_default_options": {"members": True, "inherited-members": True},
        "python_use_unqualified_type_names": True,
        "python_maximum_signature_line_length": 88,
        "add_module_names": False,
        "myst_heading_anchors": 3,
    }
