"""One room in six projections: its closed forms, the bins of its maps, conversions, and a real mirror ball.

Planted: images left for right, one projection taken for another, cosines left out, light from behind a plane.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import chdtrc

import transport as tp
from tests.agreement import assert_agrees, assert_rejected
from transport.scene.cameras import BALL, EQUAL_AREA, FISHEYE, PROJECTIONS
from transport.scene.resampling import overlaps
from transport.sims import panorama
from transport.theory.solid_angles import polygon_projected_solid_angle, rectangle_projected_solid_angle
from transport.verification.experiment import run_experiment

PIXELS, BLOCK = 64, 8
FALSE_ALARM = 1e-5
NORMALS = list(panorama.PLANES.values())
CUBE_FACES = [
    [(1, -1, -1), (1, 1, -1), (1, 1, 1), (1, -1, 1)], [(-1, -1, -1), (-1, -1, 1), (-1, 1, 1), (-1, 1, -1)],
    [(-1, 1, -1), (-1, 1, 1), (1, 1, 1), (1, 1, -1)], [(-1, -1, -1), (1, -1, -1), (1, -1, 1), (-1, -1, 1)],
    [(-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)], [(-1, -1, -1), (-1, 1, -1), (1, 1, -1), (1, -1, -1)],
]  # fmt: skip


@pytest.fixture(scope="module")
def seen():
    """The outcomes of the ball, its photograph and an equal-area map, by projection."""
    settings = {"pixels": PIXELS}
    found = {}
    for seed, projection in enumerate((BALL, panorama.PHOTO, EQUAL_AREA)):
        case = settings | {"projection": projection}
        [found[projection]] = run_experiment(panorama, case, particles=600_000, seed=1 + 1000 * seed)
    return found


def even_directions(number):
    """Unit vectors with equal solid angles (Fibonacci's lattice)."""
    mu = 1 - (2 * np.arange(number) + 1) / number
    phi = 2 * math.pi * ((np.arange(number) * panorama.GOLDEN) % 1.0)
    across = np.sqrt(1 - mu * mu)
    return np.stack([across * np.cos(phi), across * np.sin(phi), mu], axis=1)


def exact_radiance(view, each=6):
    """Mean radiance of the pixels of a map, from the geometry of the room."""
    total, weights = 0.0, 0.0
    for i in range(each):
        for j in range(each):
            rays, weight = view.rays((i + 0.5) / each, (j + 0.5) / each)
            total, weights = total + weight * panorama.radiance_along(rays), weights + weight
    mean = np.divide(total, weights, out=np.zeros_like(total), where=weights > 0)
    return mean.reshape(view.solid_angles().shape)


# Closed forms


def test_the_closed_forms_are_the_integrals_of_what_the_point_sees():
    """Nothing hides what it should not: sums over 2 million even directions, to 3 digits."""
    rays = even_directions(2_000_000)
    radiance = panorama.radiance_along(rays)
    assert 4 * math.pi * radiance.mean() == pytest.approx(panorama.fluence_rate(), rel=3e-4)
    for normal in NORMALS:
        cosine = np.maximum(rays @ normal / np.linalg.norm(normal), 0)
        assert 4 * math.pi * (radiance * cosine).mean() == pytest.approx(
            panorama.irradiance(normal), rel=3e-4
        )


@pytest.mark.parametrize("normal", [(0, 0, 1), (1, 2, -3), (-1e-3, 1, 0), (1, 1, 1)])
def test_the_faces_of_a_cube_fill_the_hemisphere_of_any_plane(normal):
    for place in ((0, 0, 0), (0.3, -0.8, 0.1)):
        parts = [polygon_projected_solid_angle(face, normal, place) for face in CUBE_FACES]
        assert sum(parts) == pytest.approx(math.pi, rel=1e-14)


def test_a_polygon_counts_as_far_as_it_is_before_the_plane():
    square = [(0.5, 0.3, 1), (-0.5, 0.3, 1), (-0.5, -0.3, 1), (0.5, -0.3, 1)]
    on_axis = rectangle_projected_solid_angle(1.0, 0.6, 1.0)
    assert polygon_projected_solid_angle(square, (0, 0, 2)) == pytest.approx(on_axis, rel=1e-14)
    assert polygon_projected_solid_angle(square, (0, 0, -1)) == 0
    halves = [
        [(x * s, y, z) for x, y, z in [(0, 0.3, 1), (0.5, 0.3, 1), (0.5, -0.3, 1), (0, -0.3, 1)]]
        for s in (1, -1)
    ]
    whole, front, back = (polygon_projected_solid_angle(each, (1, 0, 0)) for each in (square, *halves))
    assert whole == pytest.approx(front, rel=1e-14) and back == 0


@pytest.mark.parametrize("projection", PROJECTIONS)
def test_what_bins_add_to_irradiance_is_the_covariance_within_them(projection):
    """Means of all pixels by 36 rays each, and their irradiance: with and without the bins, by the same rays."""
    view, normal = panorama.environment_map(projection, 32), panorama.PLANES["aslant"]
    each, across = 12, np.array(normal) / np.linalg.norm(normal)
    sums, products, weights = 0.0, 0.0, 0.0
    for i in range(each):
        for j in range(each):
            rays, weight = view.rays((i + 0.5) / each, (j + 0.5) / each)
            light = weight * panorama.radiance_along(rays)
            sums, weights = sums + light, weights + weight
            products = products + light * np.maximum(rays @ across, 0)
    inside = weights > 0
    angles = view.solid_angles().ravel()[inside] / weights[inside]
    by_bins = sums[inside] / weights[inside] @ view.projected_solid_angles(normal).ravel()[inside]
    added = by_bins - products[inside] @ angles
    exact = panorama.irradiance(normal)
    assert panorama.binning(projection, 32, normal) == pytest.approx(added, abs=4e-4 * exact)
    assert panorama.binning(projection, 128, normal) < 1e-3 * exact


# Maps


def test_planted_faults_of_a_map_are_rejected(seen):
    """Its picture left for right; pixels with the solid angles of another projection; solid angles without the cosine."""
    outcome = seen[EQUAL_AREA]
    result, radiance = outcome.result, outcome.result["map"].radiance
    view, normal = outcome.result["map"].detector, panorama.PLANES["to the window"]
    row = outcome[panorama.IRRADIANCE.format("to the window")]
    weights = view.projected_solid_angles(normal)
    assert_agrees(row.estimate, row.exact, FALSE_ALARM)
    assert_rejected(panorama._sum(result, radiance, weights[:, ::-1]), row.exact, FALSE_ALARM)
    assert_rejected(panorama._sum(result, radiance, weights.T), row.exact, FALSE_ALARM)
    assert_rejected(panorama._sum(result, radiance, view.solid_angles() / 2), row.exact, FALSE_ALARM)
    other = panorama.environment_map(FISHEYE, PIXELS)
    assert_rejected(
        panorama._sum(result, radiance, other.projected_solid_angles(normal)), row.exact, FALSE_ALARM
    )
    fluence = outcome[panorama.FLUENCE]
    assert_agrees(fluence.estimate, fluence.exact, FALSE_ALARM)
    assert_rejected(panorama._sum(result, radiance, other.solid_angles()), fluence.exact, FALSE_ALARM)


@pytest.mark.parametrize("projection", PROJECTIONS)
def test_conversions_keep_the_fluence_rate_to_rounding_and_irradiance_to_the_blur_of_pixels(projection):
    """Of each projection into the next: E changes by at most 12 over the square of the pixels along a side.

    Planted: the converted map left for right.
    """
    pixels = 32
    view = panorama.environment_map(projection, pixels)
    other = panorama.environment_map(panorama.following(projection), pixels)
    radiance = exact_radiance(view, each=4)
    converted = view.resampled(radiance, other)
    fluence = (radiance * view.solid_angles()).sum()
    assert (converted * other.solid_angles()).sum() == pytest.approx(fluence, rel=1e-12)
    changes = []
    for normal in [*NORMALS, (-1, 0, 0)]:
        weights = other.projected_solid_angles(normal)
        before = (radiance * view.projected_solid_angles(normal)).sum()
        assert (converted * weights).sum() == pytest.approx(before, rel=12 / pixels**2)
        changes.append(abs((converted[..., ::-1] * weights).sum() - before) / before)
    assert max(changes) > 4 * 12 / pixels**2


WHOLE = {
    "strips": (tp.EnvironmentMap(name="a", position=(0, 0, 0), theta=34, phi=68), 23, "cylinder"),
    "few": (tp.EnvironmentMap(name="a", position=(0, 0, 0), theta=1, phi=3), 7, "cylinder"),
    "slivers": (tp.EnvironmentMap(name="a", position=(0, 0, 0), projection=BALL, pixels=27), 26, FISHEYE),
}  # fmt: skip


@pytest.mark.parametrize("name", WHOLE)
def test_conversions_share_all_cells_out_where_edges_nearly_coincide(name):
    """34 rows of equal angles and 23 of equal heights have edges closer than the points of a cell: a thin strip."""
    view, number, projection = WHOLE[name]
    size = {"theta": number, "phi": 2 * number} if projection == "cylinder" else {"pixels": number}
    other = tp.EnvironmentMap(name="b", position=(0, 0, 0), projection=projection, **size)
    for one, two in ((view, other), (other, view)):
        shared = overlaps(one, two)
        assert shared.data.min() > 0
        np.testing.assert_allclose(shared.sum(axis=0), one.solid_angles().ravel(), rtol=1e-9, atol=1e-14)
        np.testing.assert_allclose(shared.sum(axis=1), two.solid_angles().ravel(), rtol=1e-9, atol=1e-14)


# The mirror ball


def chi_square(one, other):
    """X² of two images by blocks of pixels within the rim, and how many blocks there are."""
    v, u = np.meshgrid(*[np.linspace(-1, 1, PIXELS + 1)] * 2, indexing="ij")
    far = np.hypot(v, u)
    corners = np.max([far[:-1, :-1], far[1:, :-1], far[:-1, 1:], far[1:, 1:]], axis=0)
    found = []
    for row in range(0, PIXELS, BLOCK):
        for column in range(0, PIXELS, BLOCK):
            place = (slice(None), slice(row, row + BLOCK), slice(column, column + BLOCK))
            inside = corners[place[1:]] < 1
            if inside.all():
                means = [values[place].mean(axis=(1, 2)) for values in (one, other)]
                variance = sum(each.var(ddof=1) / len(each) for each in means)
                found.append((means[0].mean() - means[1].mean()) ** 2 / variance)
    return sum(found), len(found)


def test_a_mirror_ball_is_an_equal_area_map_as_its_photograph_shows(seen):
    """The photograph of a real one against the map, by blocks of pixels.  False alarm 1e-5.

    Planted: left for right, upside down, a fisheye's map in its place.
    """
    ball, photo = (
        seen[BALL].result["map"].radiance.values,
        seen[panorama.PHOTO].result["photo"].radiance.values,
    )
    value, blocks = chi_square(ball, photo)
    assert blocks > 30
    assert chdtrc(blocks, value) > FALSE_ALARM
    for wrong in (ball[:, :, ::-1], ball[:, ::-1], ball.swapaxes(1, 2)):
        value, blocks = chi_square(wrong, photo)
        assert chdtrc(blocks, value) < FALSE_ALARM
    stretched = 0.97 * (np.arange(PIXELS) + 0.5 - PIXELS / 2) + PIXELS / 2  # a ball that looks 3 % larger
    nearest = np.floor(stretched).astype(int)
    value, blocks = chi_square(ball[:, nearest][:, :, nearest], photo)
    assert chdtrc(blocks, value) < FALSE_ALARM


def test_the_photograph_has_the_light_of_the_room(seen):
    """Planted: the wall beyond its rim is taken for what the mirror shows; its image is turned."""
    outcome = seen[panorama.PHOTO]
    result, photo = outcome.result, outcome.result["photo"].radiance
    for row in outcome.rows:
        assert_agrees(row.estimate, row.exact, FALSE_ALARM)
    row, view = outcome[panorama.FLUENCE], panorama.environment_map(BALL, PIXELS)
    assert_rejected(
        panorama._sum(result, photo, np.full((PIXELS, PIXELS), 16 / PIXELS**2)), row.exact, FALSE_ALARM
    )
    row = outcome[panorama.IRRADIANCE.format("to the window")]
    mirrored = view.projected_solid_angles((-1, 0, 0))
    assert_rejected(panorama._sum(result, photo, mirrored), row.exact, FALSE_ALARM)
