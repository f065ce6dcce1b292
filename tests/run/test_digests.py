"""The comparison of digests fails for one bit, and for a number that is missing."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from tests.digests import WORLDS, app, digest_of, runs
from transport.compile.methods import ESTIMATORS, SAMPLINGS
from transport.statistics.estimates import Batches, Estimate

RUN = Batches(np.array([10, 10, 10]))


def estimate(values):
    return Estimate(np.array(values), RUN, "W")


def test_one_bit_of_one_batch_changes_the_digest():
    one, other = estimate([1.0, 2.0, 3.0]), estimate([1.0, 2.0, np.nextafter(3.0, 4.0)])
    assert digest_of(one) == digest_of(estimate([1.0, 2.0, 3.0])) != digest_of(other)
    assert digest_of(0.0) != digest_of(-0.0)


@pytest.mark.parametrize(
    ("after", "difference"),
    [
        ({"sim sun": {"flux": "a", "error": "b"}}, None),
        ({"sim sun": {"flux": "a", "error": "c"}}, "sim sun: error"),
        ({"sim sun": {"flux": "a"}}, "sim sun: error"),
        ({"sim sun": {"flux": "a", "error": "b"}, "world 1": {"flux": "d"}}, "world 1: flux"),
        ({}, "sim sun: flux"),
    ],
    ids=["equal", "another bit", "a number less", "a run more", "no run"],
)
def test_a_comparison_names_each_difference_and_exits_with_its_status(tmp_path, after, difference):
    before = {"sim sun": {"flux": "a", "error": "b"}}
    paths = [tmp_path / name for name in ("before.json", "after.json")]
    for path, digests in zip(paths, (before, after), strict=True):
        path.write_text(json.dumps(digests))
    done = CliRunner().invoke(app, ["compare", *map(str, paths)])
    assert done.exit_code == (difference is not None)
    assert difference is None or difference in done.output.splitlines()


@pytest.mark.slow
def test_the_runs_cover_sims_hard_cases_worlds_and_scenes_in_every_estimator_and_sampling():
    names = [name for name, _ in runs(worlds=6)]
    assert WORLDS == 200 and len(names) == len(set(names)) > 700
    assert {name.split()[0] for name in names} == {"sim", "hard", "world", "scene"}
    ends = {name.rpartition(", ")[2] for name in names}
    assert {*ESTIMATORS, *SAMPLINGS, "to an error", "paths"} <= ends
