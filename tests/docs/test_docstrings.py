"""Docstrings of public names: Parameters match signatures, Examples run, no text is read as markup."""

from __future__ import annotations

import ast
import dataclasses
import doctest
import functools
import importlib
import inspect
import io
import itertools
import re
import tokenize
from collections import Counter
from pathlib import Path

import pytest

import transport as tp
from transport.cli.docs import RETURNED_CLASSES
from transport.validation import parameters_of

PACKAGE = Path(tp.__file__).parent
RETURNED = ("Result",)  # made by the library alone: documents Attributes instead of Parameters
HEADER = re.compile(r"^-{3,}\s*$")  # the line below the title of a section
DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
NOT_CONSTANTS = re.compile(  # abbreviations; what a user types
    "ASCII|BRDF|COLUMNS|DLMF|EGSR|EPYC|HTML|IEEE|JCGT|JSON|LLVM|MCML|MCNP|NAME|README|SIAM|SIGGRAPH|TAOCP|NUMBA_.*|.*DONTNEED"
)
CODE = re.compile(r"``.+?``|`[^`]+`")
MARKUP = re.compile(r"(?:^|(?<=[\s(\[{<'\"/:-]))(?:\*+(?=[^\s*])|\|(?=\S)[^|\n]*\|)")


# Public classes and functions by name, without conversion factors, exceptions and warnings.
PUBLIC = {
    name: value
    for name, value in ((name, getattr(tp, name)) for name in tp.__all__)
    if callable(value) and not (isinstance(value, type) and issubclass(value, BaseException))
}
MODULES = {
    ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(".__init__"): path
    for path in sorted(PACKAGE.rglob("*.py"))
    if ">>>" in path.read_text(encoding="utf-8")
}


def sections(value):
    """The sections of a numpydoc docstring: title -> lines."""
    lines = inspect.cleandoc(value.__doc__ or "").splitlines()
    heads = [place - 1 for place, line in enumerate(lines) if place and HEADER.match(line)]
    ends = [*heads[1:], len(lines)] if heads else []
    return {lines[head]: lines[head + 2 : end] for head, end in zip(heads, ends, strict=True)}


def parameters(value):
    """The parameters of a function or class; of a dataclass also those that are no fields."""
    if isinstance(value, type) and dataclasses.is_dataclass(value):
        return [field.name for field in parameters_of(value)]
    return [name for name in inspect.signature(value).parameters if not name.startswith("_")]


def parameter_faults(value):
    """What is wrong with the Parameters section of a docstring."""
    entries = [line for line in sections(value).get("Parameters", ()) if line and not line[0].isspace()]
    told = Counter(
        name.strip().lstrip("*") for entry in entries for name in re.split(r"\s:", entry)[0].split(",")
    )
    known = parameters(value)
    faults = [f"{name} is not documented" for name in known if name not in told]
    faults += [f"{name} is not a parameter" for name in told if name not in known]
    return faults + [f"{name} is documented twice" for name, count in told.items() if count > 1]


def example_faults(value):
    """What is wrong with the Examples section of a docstring."""
    examples = sections(value).get("Examples")
    if examples is None:
        return ["no Examples section"]
    return [] if any(line.lstrip().startswith(">>>") for line in examples) else ["Examples has no doctest"]


def markup_faults(text):
    """Stars and bars in a docstring that Sphinx would read as emphasis or as a substitution."""
    faults = []
    for line in inspect.cleandoc(text or "").splitlines():
        if not line.lstrip().startswith((">>>", "...", "*args", "**", "* ")) and not re.match(
            r"\*+\w+ :", line
        ):
            faults += [found.strip() for found in MARKUP.findall(CODE.sub("x", line))]
    return faults


def header_faults(text):
    """Underlines of sections with text behind them or of another length than the title, which are read as text."""
    lines = inspect.cleandoc(text or "").splitlines()
    return [
        line
        for title, line in itertools.pairwise(lines)
        if re.match(r"-{3,}", line) and (line != "-" * len(title) or not title.strip())
    ]


def unknown_constants(text):
    """Names in capitals in the comments and docstrings of a source that it does not define or import.

    A name may be of another module, as in `layout.ROUNDING`, or be followed by its file.
    """
    tokens = list(tokenize.generate_tokens(io.StringIO(text).readline))
    own = {token.string for token in tokens if token.type == tokenize.NAME}
    nodes = [node for node in ast.walk(ast.parse(text)) if isinstance(node, DOCUMENTED)]
    told = [
        token.string for token in tokens if token.type == tokenize.COMMENT and ": noqa" not in token.string
    ]
    told += [line for node in nodes for line in (ast.get_docstring(node) or "").splitlines()]
    found = [
        (line, name)
        for line in told
        if ">>>" not in line
        for name in re.findall(r"(?<![\w<.-])(?:[a-z_]+\.)?[A-Z][A-Z_]{3,}\b", line)
    ]
    return sorted(
        {
            name
            for line, name in found
            for known in [names_of_module(name.partition(".")[0]) if "." in name else own]
            if name.rpartition(".")[2] not in known
            and not NOT_CONSTANTS.fullmatch(name)
            and ".py" not in line
        }
    )


@functools.cache
def names_of_module(stem):
    """Names in the modules of a name, such as "layout"."""
    texts = [path.read_text(encoding="utf-8") for path in PACKAGE.rglob(f"{stem}.py")]
    return {node.id for text in texts for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Name)}


def doctests_of(module):
    """The doctests of a module, also those of cached properties; those of public names have empty globals."""
    finder = doctest.DocTestFinder(exclude_empty=True)
    found = finder.find(module)
    for kind in vars(module).values():
        if isinstance(kind, type) and kind.__module__ == module.__name__:
            for name, member in vars(kind).items():
                if isinstance(member, functools.cached_property):
                    title = f"{module.__name__}.{kind.__name__}.{name}"
                    found += finder.find(member.func, title, module=False, globs=vars(module))
    tests = [test for test in {test.name: test for test in found}.values() if test.examples]
    for test in tests:
        if test.name.removeprefix(f"{module.__name__}.").split(".")[0] in PUBLIC:
            test.globs = {}
    return tests


def run_doctests(tests):
    """Run doctests and return the reports of those that fail."""
    reports = []
    runner = doctest.DocTestRunner(verbose=False)
    for test in tests:
        runner.run(test, out=reports.append)
    return reports


@pytest.mark.parametrize("name", PUBLIC)
def test_a_public_name_documents_the_parameters_of_its_signature_and_has_an_example(name):
    value = PUBLIC[name]
    if name in RETURNED:
        assert "Attributes" in sections(value)
    else:
        assert parameter_faults(value) == []
    assert example_faults(value) == []
    assert value.__module__ in MODULES


@pytest.mark.parametrize("name", MODULES)
def test_examples_give_what_they_show(name):
    """Examples of public names import all that they use."""
    tests = doctests_of(importlib.import_module(name))
    assert tests
    assert "".join(run_doctests(tests)) == ""


def _documented():
    """Docstrings of the reference by name: public names and what results return, with their members."""
    found = {}
    for value in (*PUBLIC.values(), *RETURNED_CLASSES):
        found[f"{value.__module__}.{value.__qualname__}"] = value.__doc__
        members = inspect.getmembers_static(value) if isinstance(value, type) else ()
        for name, member in members:
            doc = getattr(getattr(member, "func", member), "__doc__", None)
            is_own = not name.startswith("_") and callable(getattr(member, "__get__", None))
            if is_own and doc is not None:
                found[f"{value.__module__}.{value.__qualname__}.{name}"] = doc
    return found


@pytest.mark.parametrize("faults_of", [markup_faults, header_faults])
def test_docstrings_of_the_reference_are_read_as_they_are_meant(faults_of):
    """Sphinx reads |mu| as a substitution and *dims as emphasis; as code (``|mu|``) they are text.

    It reads a title whose underline is of another length as text.
    """
    faults = {name: faults_of(doc) for name, doc in _documented().items()}
    assert {name: found for name, found in faults.items() if found} == {}


@pytest.mark.slow
def test_properties_have_no_colon_in_the_first_line_which_sphinx_takes_for_their_type():
    wrong = [
        f"{base.__name__}.{name}: {line}"
        for base in {each for value in PUBLIC.values() if isinstance(value, type) for each in value.__mro__}
        for name, member in vars(base).items()
        if isinstance(member, property | functools.cached_property)
        and not name.startswith("_")
        and ": " in (line := (member.__doc__ or "").partition("\n")[0])
    ]
    assert wrong == []


def test_constants_named_in_comments_and_docstrings_exist():
    texts = {path: path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py")}
    faults = {str(path): unknown_constants(text) for path, text in texts.items()}
    assert {path: found for path, found in faults.items() if found} == {}


# ---- the checks can fail ----


@dataclasses.dataclass
class Whole:
    """A disk.

    Parameters
    ----------
    radius, height : float
        Size [m].
    name : str, default ""
        A name.

    Examples
    --------
    >>> 1 + 1
    2
    """

    radius: float
    height: float
    name: str = ""
    area: float = dataclasses.field(init=False, default=0.0)


def planted(doc, *, keep=("radius",)):
    """A function of these parameters with this docstring."""

    def made(*values):
        """Replaced below."""

    made.__doc__ = doc
    made.__signature__ = inspect.Signature(
        [inspect.Parameter(name, inspect.Parameter.POSITIONAL_OR_KEYWORD) for name in keep]
    )
    return made


def disk(entries):
    return planted(f"A disk.\n\nParameters\n----------\n{entries}")


RADIUS = "radius : float\n    Radius [m].\n"
MORE = dataclasses.make_dataclass("More", [("width", float)], bases=(Whole,), kw_only=True)
MORE.__doc__ = Whole.__doc__
NO_EXAMPLES, NO_DOCTEST = ["no Examples section"], ["Examples has no doctest"]
PLANTED = [  # what looks for faults, where, what it finds
    (parameter_faults, Whole, []),
    (parameter_faults, disk(f"*{RADIUS}\nReturns\n-------\nint\n"), []),
    (parameter_faults, disk(""), ["radius is not documented"]),
    (parameter_faults, disk("raduis : float\n"), ["radius is not documented", "raduis is not a parameter"]),
    (parameter_faults, disk(RADIUS + RADIUS), ["radius is documented twice"]),
    (parameter_faults, MORE, ["width is not documented"]),
    (example_faults, Whole, []),
    (example_faults, planted("A disk."), NO_EXAMPLES),
    (example_faults, planted("A disk.\n\nExamples\n--------\nLook.\n"), NO_DOCTEST),
    (markup_faults, Whole.__doc__, []),
    (markup_faults, "Means, shape (B, *dims).", ["*"]),
    (markup_faults, "∫ |cosθ| dω", ["|cosθ|"]),
    (markup_faults, "``|mu|`` and `*dims`", []),
    (markup_faults, "2 * 3 and a | b", []),
    (markup_faults, ">>> f(*x) | y | z", []),
    (markup_faults, "*runs : Result", []),
    (header_faults, "A lens.\n\nNotes\n-----\nThin.", []),
    (header_faults, "A lens.\n\nNotes\n----- Thin.", ["----- Thin."]),
    (header_faults, "A lens.\n\nNotes\n------\nThin.", ["------"]),
    (unknown_constants, "# at most LIMIT\nLIMIT = 3\n", []),
    (unknown_constants, "# at most LIMIT\nMOST = 3\n", ["LIMIT"]),
    (unknown_constants, '"""At most layout.ROUNDING."""\n', []),
    (unknown_constants, '"""At most layout.SLACKNESS."""\n', ["layout.SLACKNESS"]),
    (unknown_constants, "# as JSON or HTML\n", []),
    (unknown_constants, "# by PATIENCE of engine/driver.py\n", []),
]


@pytest.mark.parametrize(("faults_of", "where", "faults"), PLANTED)
def test_planted_faults_are_reported_and_sound_docstrings_have_none(faults_of, where, faults):
    assert faults_of(where) == faults


@pytest.mark.parametrize("example", [">>> 1 + 1\n3\n", ">>> math.pi\n3.14\n"])
def test_a_planted_wrong_example_is_reported(example):
    wrong = planted(f"A disk.\n\nExamples\n--------\n{example}")
    tests = doctest.DocTestFinder().find(wrong, "wrong", module=False, globs={})
    assert len(run_doctests(tests)) == 1
