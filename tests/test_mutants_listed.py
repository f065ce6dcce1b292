"""The faults of tests/mutants can still be planted: their texts are where they are said to be, and so are their tests."""

from __future__ import annotations

import pytest

from tests.mutants import FAULTS
from tests.mutants.fault import ROOT, Fault

LEAST = 60


def test_each_fault_has_its_one_place_and_leaves_code():
    texts = {fault.path: fault.source.read_text() for fault in FAULTS}
    for fault in FAULTS:
        assert fault.planted(texts[fault.path]) != texts[fault.path], fault.what


def test_the_tests_that_are_to_see_them_are_there():
    missing = [f"{fault.what}: {node}" for fault in FAULTS for node in fault.nodes if not is_there(node)]
    assert missing == [] and all(fault.tests for fault in FAULTS)


def is_there(node):
    file, _, name = node.partition("::")
    return (ROOT / file).is_file() and (not name or f"def {name}(" in (ROOT / file).read_text())


def test_there_are_many_and_none_is_listed_twice():
    assert len({fault.what for fault in FAULTS}) == len(FAULTS) >= LEAST
    assert len({(fault.path, fault.old, fault.new) for fault in FAULTS}) == len(FAULTS)


def test_a_fault_without_its_place_is_reported():
    lost = Fault("physics/rays.py", "no such text", "x", "what is not there", ("test_rays",))
    with pytest.raises(ValueError, match="what is not there"):
        lost.planted((ROOT / lost.path).read_text())
    with pytest.raises(SyntaxError):
        Fault("physics/rays.py", "a = 1", "a =", "no code", ("test_rays",)).planted("a = 1\n")
    assert not is_there("tests/test_rays.py::test_that_nobody_has_written")
