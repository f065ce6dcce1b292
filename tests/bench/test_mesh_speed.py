"""How meshes scale; not in the default run, since a busy machine fails it.

pytest -m bench tests/bench
"""

import pytest

from tests.bench.mesh import measure

pytestmark = pytest.mark.bench


@pytest.fixture(scope="module")
def rows():
    return measure(repeats=7)


def test_time_a_ray_grows_less_than_5_fold_from_100_to_100_000_triangles(rows):
    assert rows[-1]["ns"] < 5 * rows[1]["ns"]


def test_100_000_triangles_are_made_and_built_within_a_second(rows):
    assert rows[-1]["triangles"] >= 100_000 and rows[-1]["made"] + rows[-1]["built"] < 1.0
