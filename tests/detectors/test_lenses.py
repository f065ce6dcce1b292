"""Lenses of cameras, projections of environment maps and light fields: what a uniform sky, a lamp and a wall must show.

A uniform field has one radiance in each pixel of all of them, whatever their weights.  What a lamp fills of a picture is counted in
another way, and light that comes by glass, for which histories start at lamps too, must lie in the same pixels of each projection.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy import integrate

import transport as tp
from tests.agreement import assert_agrees
from tests.refusals import assert_refused
from tests.slow import quick
from transport.compile import adjoint, caustics
from transport.scene.projections import PINHOLE, RADIUS_OF_ALL, pixel_solid_angles, radial_places, radial_rays

L = 100.0  # W m^-2 sr^-1, of the sky
SKY = tp.Source(tp.Sphere(radius=10.0), tp.Lambertian(radiance=L), side="inside")
AHEAD = {"name": "view", "position": (0.1, -0.2, 0.3), "direction": (0.2, 1, 0.1), "pixels": (8, 6)}
LENSES = {
    "pinhole": {"field_of_view": 1.5},
    "fisheye": {},
    "fisheye of all directions": {"lens": "fisheye", "field_of_view": 2 * math.pi, "pixels": (9, 9)},
    "equal-area fisheye": {"field_of_view": 3.0},
    "orthographic": {"width": 2.0},
    "thin lens": {"aperture": 0.4, "focal_length": 0.5, "focus": 2.0, "field_of_view": 1.2},
}
PROJECTIONS = ("latitude-longitude", "cylinder", "cube", "fisheye", "equal-area fisheye", "mirrored ball")
FINE = {
    name: {"theta": 12, "phi": 24} if k < 2 else {"pixels": 8 if k == 2 else 20}
    for k, name in enumerate(PROJECTIONS)
}
MAPS = [
    tp.EnvironmentMap(name="map", position=(0.1, -0.4, 0.2), projection=name, **FINE[name])
    for name in PROJECTIONS
]
FINER = [
    replace(each, **({"theta": 24, "phi": 48} if k < 2 else {"pixels": 2 * each.pixels}))
    for k, each in enumerate(MAPS)
]
NORMALS = ((0, 0, 1), (1, 2, -2), (-0.6, 0.0, -0.8))


def camera(lens, **how):
    return tp.Camera(**{**AHEAD, "lens": lens if " of " not in lens else "fisheye", **LENSES[lens], **how})


def run(scene, particles=200_000, seed=1, **how):
    return tp.simulate(scene, particles, seed=seed, progress=False, **how)


def seen(view, *surfaces, sources=SKY, particles=200_000, **how):
    return run(tp.Scene(sources, surfaces, view), particles, **how)[view.name]


def assert_alike(radiance, exact, inside=None):
    """Each bin agrees, and all together; bins of equal scores, which have no error of their own, to rounding."""
    value, error = np.atleast_1d(radiance.value - exact, radiance.error)
    value, error = (each if inside is None else each[inside] for each in (value, error))
    known = np.isfinite(error) & (error > 0)
    np.testing.assert_allclose(value[~known], 0.0, atol=1e-9 * max(np.max(np.abs(exact)), 1.0))
    scores = value[known] / error[known]
    assert np.abs(scores).max(initial=0.0) < 4.5, np.abs(scores).max()
    assert np.sqrt(np.sum(scores**2) / max(len(scores), 1)) < 1 + 2.5 / math.sqrt(max(len(scores), 1)), (
        np.sqrt(np.mean(scores**2))
    )


# ---- a uniform sky ----


@pytest.mark.parametrize("lens", LENSES)
def test_a_uniform_sky_is_as_bright_in_each_pixel(lens):
    view = camera(lens)
    radiance = seen(view).radiance
    inside = view.cell_measures().values > 0
    assert (radiance.value[~inside] == 0).all()
    assert_alike(radiance, L, inside)


@pytest.mark.parametrize("view", MAPS, ids=PROJECTIONS)
def test_a_map_of_a_uniform_sky_has_its_radiance_fluence_rate_and_irradiance(view):
    reading = seen(view)
    assert_alike(reading.fluence_rate, 4 * math.pi * L)
    for normal in NORMALS:
        assert_alike(reading.irradiance_on(normal), math.pi * L)


def test_the_film_of_a_thin_lens_is_lit_by_what_the_lens_subtends():
    """On the axis E = pi L (D/2)^2/((D/2)^2 + v^2); a small aperture off the axis: pi L (D/2v)^2 cos^4."""
    for aperture in (0.05, 0.3, 0.95):
        narrow = camera("thin lens", aperture=aperture, pixels=(1, 1), field_of_view=1e-6)
        r, v = aperture / 2, narrow.image_distance
        assert_agrees(seen(narrow).irradiance[0, 0], math.pi * L * r**2 / (r**2 + v**2))
    wide = camera("thin lens", aperture=1e-3, field_of_view=2.0, pixels=(9, 1), focus=None)
    u = wide.edges()["u"]
    means = np.array(
        [
            integrate.quad(lambda x: (1 + x * x) ** -2, a, b)[0] / (b - a)
            for a, b in zip(u[:-1], u[1:], strict=True)
        ]
    )
    height = wide.edges()["v"][1]
    assert height < 0.2
    across = [
        integrate.quad(lambda y, x=x: (1 + x * x + y * y) ** -2 / (1 + x * x) ** -2, 0, height)[0] / height
        for x in (u[1:] + u[:-1]) / 2
    ]
    exact = math.pi * L * (1e-3 / 2 / wide.image_distance) ** 2 * means * across
    assert_alike(seen(wide).irradiance[0], exact)


def test_cells_of_a_light_field_of_a_uniform_sky_have_its_radiance_and_their_throughput():
    field = tp.LightField(
        name="field",
        position=(0, 0, 0),
        direction=(0, 1, 0),
        distance=2.0,
        size=(0.6, 0.4),
        far_size=(2, 1),
        views=(2, 3),
        pixels=(4, 5),
    )
    reading = seen(field, particles=400_000)
    assert reading.radiance.dims == tuple("uvst")
    assert_alike(reading.radiance, L)
    near, far = (
        tp.Rectangle(center=(0, 0, z), normal=(0, 0, 1 - 2 * (z > 0)), width=w, height=h)
        for z, (w, h) in ((0, field.size), (2, field.far_size))
    )
    exact = math.pi * near.area * tp.view_factor(near, far, particles=1e6, seed=1).value
    assert field.cell_measures().values.sum() == pytest.approx(exact, rel=2e-3)
    assert_alike(reading.flux_in, L * field.cell_measures().values.sum())


# ---- where things are ----


def test_solid_angles_of_pixels_are_those_of_their_directions():
    edges = np.array([-1.3, -0.3, 0.4, 1.1])
    for projection in (PINHOLE, *RADIUS_OF_ALL):
        found = pixel_solid_angles(projection, edges, edges)
        for row, column in ((0, 0), (1, 2), (2, 1)):

            def density(v, u, projection=projection):
                """Cross product of the derivatives of the direction, by differences."""
                step = 1e-4
                d = [
                    radial_rays(projection, np.array(u + a), np.array(v + b))
                    for a, b in ((step, 0), (-step, 0), (0, step), (0, -step))
                ]
                return np.linalg.norm(np.cross(d[0] - d[1], d[2] - d[3])) / (4 * step * step)

            exact, _ = integrate.dblquad(
                density, *edges[column : column + 2], *edges[row : row + 2], epsrel=1e-6
            )
            assert found[row, column] == pytest.approx(exact, rel=1e-4)
    for projection, rim in RADIUS_OF_ALL.items():
        for pixels in (1, 2, 7, 40):
            whole = np.linspace(-rim, rim, pixels + 1)
            assert pixel_solid_angles(projection, whole, whole).sum() == pytest.approx(4 * math.pi, rel=1e-13)


def test_places_in_an_image_are_those_of_its_rays():
    rng = np.random.default_rng(1)
    for projection in (PINHOLE, *RADIUS_OF_ALL):
        u, v = rng.uniform(-1.1, 1.1, (2, 50))
        np.testing.assert_allclose(
            radial_places(projection, radial_rays(projection, u, v)), (u, v), rtol=1e-12
        )


@pytest.mark.parametrize("view", MAPS, ids=PROJECTIONS)
def test_a_lamp_is_in_the_bin_of_its_direction(view):
    for where in ((3, 0.4, 0.7), (-0.5, -3, 0.6), (0.3, 0.5, -3), (-1, 2, 2)):
        lamp = tp.Source(
            tp.Sphere(center=tuple(np.add(view.position, where)), radius=0.02), tp.Lambertian(radiance=1.0)
        )
        radiance = seen(view, sources=lamp, particles=400_000).radiance
        lit = np.flatnonzero(radiance.value.ravel())
        expected = view.cells_of(np.array([where]) / np.linalg.norm(where))
        assert len(lit) and expected[0] in lit and len(lit) <= 4
        exact = 2 * math.pi * (1 - math.sqrt(1 - 0.02**2 / np.dot(where, where)))
        assert_agrees((radiance * view.solid_angles()).sum(), exact)


@pytest.mark.parametrize("lens", ["pinhole", "fisheye", "equal-area fisheye", "orthographic", "thin lens"])
def test_pictures_are_upright_and_not_mirrored(lens):
    """Looking along +x with +z up, +y is on the left."""
    how = {"direction": (1, 0, 0), "position": (0, 0, 0)} | ({"width": 6.0} if lens == "orthographic" else {})
    view = camera(lens, **how)
    lamp = tp.Source(tp.Sphere(center=(4, 1.2, 0.9), radius=0.3), tp.Lambertian(radiance=3.0))
    row, column = np.unravel_index(np.argmax(seen(view, sources=lamp).image()), (6, 8))
    assert row < 3 and column < 4


def test_rays_of_pixels_are_those_that_histories_take():
    """A wall whose picture is computed from its rays: bright where they meet the lamp."""
    lamp = tp.Rectangle(center=(0.3, 3, 0.2), normal=(0, -1, 0), width=1.1, height=0.7)
    source = tp.Source(lamp, tp.Lambertian(radiance=L))
    for lens in LENSES:
        view = camera(lens, direction=(0.1, 1, 0.05))
        radiance, total, met = seen(view, sources=source, particles=2_000_000).radiance, 0.0, 0.0
        for place in view.lens_points(6):
            for a, b in np.add(np.indices((12, 12)).reshape(2, -1).T, 0.5) / 12:
                origins, rays, weights = view.rays(a, b, place)
                with np.errstate(divide="ignore", invalid="ignore"):
                    ends = origins + (3 - origins[:, 1:2]) / rays[:, 1:2] * rays
                inside = (rays[:, 1] > 0) & (abs(ends[:, 0] - 0.3) < 0.55) & (abs(ends[:, 2] - 0.2) < 0.35)
                total, met = total + weights, met + weights * inside
        share = np.divide(met, total, out=np.zeros_like(total), where=total > 0).reshape(radiance.shape)
        assert 0.1 < share.max() <= 1
        np.testing.assert_allclose(radiance.value / L, share, atol=0.04)


# ---- light by way of glass ----

GLASS = tp.Surface(tp.Sphere(center=(0.4, 0.3, -0.3), radius=0.3), tp.Dielectric(1.5), "glass")
BALL = tp.Surface(tp.Sphere(center=(-0.4, 0.3, -0.3), radius=0.3), tp.Mirror(0.9), "mirror")
WALLS = tp.Surface(tp.Box(size=2.0), tp.Diffuse(0.6), "walls")
PANEL = tp.Source(tp.Disk(radius=0.3, center=(0, 0, 0.9)), tp.Lambertian(radiance=5.0), side="back")


@pytest.fixture(scope="module")
def through_glass():
    return [seen(view, WALLS, GLASS, BALL, sources=PANEL, particles=1_500_000) for view in MAPS]


def test_histories_from_lamps_bring_their_light_to_each_projection(through_glass):
    """The fluence rate by glass is the same in all, and that of a camera of all directions."""
    others = [each.fluence_rate for each in through_glass[1:]]
    for other in others:
        assert_agrees(other - through_glass[0].fluence_rate, 0.0)
    wide = camera("fisheye of all directions", position=MAPS[0].position, name="map")
    assert_agrees(
        seen(wide, WALLS, GLASS, BALL, sources=PANEL, particles=1_500_000).fluence_rate - others[0], 0.0
    )


COARSE = [replace(each, pixels=3 if each.projection == "cube" else 6) for each in MAPS[2:]]


def furnace(*views):
    """Diffuse walls that send on half, glass and a mirror: radiance is 1 everywhere, in each direction."""
    faces = tp.Box(size=2.0).faces().items()
    walls = [tp.Surface(face, tp.Diffuse(0.5), f"wall {name}") for name, face in faces]
    lamps = [tp.Source(wall.name, tp.Lambertian(radiance=0.5), side="back") for wall in walls]
    return tp.Scene(lamps, [*walls, GLASS, replace(BALL, material=tp.Mirror())], views)


@pytest.mark.parametrize("view", COARSE, ids=PROJECTIONS[2:])
def test_caustics_lie_in_the_right_bins_of_each_projection(view, monkeypatch):
    """In a furnace nearly all histories start at the lamps: what they bring to a wrong bin is missing in the right one."""
    for module in (caustics, adjoint):
        monkeypatch.setattr(module, "SHARE", 0.9)
    reading = run(furnace(replace(view, name="lit from lamps")), 4_000_000)["lit from lamps"]
    sums, (part,) = reading.cell_sums, reading.cell_sums.parts
    brought = sum(sums.brought_in(sums.batches[0], part, lamp) for lamp in sums.lamps)
    assert np.ptp(brought[view.cell_measures().values.ravel() > 0]) > 0.02  # uneven: misplaced light shows
    assert_alike(reading.radiance, 1.0, view.cell_measures().values > 0)


def test_a_room_of_one_radiance_looks_alike_in_all_instruments():
    """With glass and a mirror in a furnace: histories from lamps and from views share paths."""
    field = tp.LightField(
        name="field",
        position=(0, -0.8, 0),
        direction=(0, 1, 0),
        distance=0.5,
        size=(0.1, 0.1),
        far_size=(0.4, 0.4),
        views=(1, 2),
        pixels=(2, 2),
    )
    views = [
        replace(each, name=each.projection, **({"theta": 3, "phi": 4} if k < 2 else {"pixels": 3}))
        for k, each in enumerate(MAPS)
    ]
    views += [
        camera(
            lens,
            name=f"lens {lens}",
            position=(0, -0.7, 0),
            pixels=(3, 2),
            **({"width": 0.5} if lens == "orthographic" else {}),
        )
        for lens in LENSES
    ]
    result = run(furnace(*views, field), 400_000)
    for view in (*views, field):
        radiance = result[view.name].radiance
        assert_alike(radiance, 1.0, view.cell_measures().values > 0)


# ---- conversions ----


@pytest.mark.parametrize("other", FINER, ids=PROJECTIONS)
@pytest.mark.parametrize("view", quick(FINER, *FINER[1:3]), ids=lambda view: view.projection)
def test_conversions_conserve_fluence_rate_irradiance_and_a_uniform_sky(view, other):
    rays, _ = view.rays(0.5, 0.5)
    radiance = (1.5 + rays @ (0.3, -0.5, 0.7)).reshape(view.solid_angles().shape)
    found = view.resampled(radiance, other)
    assert (found * other.solid_angles()).sum() == pytest.approx(
        (radiance * view.solid_angles()).sum(), rel=1e-11
    )
    for normal in NORMALS:
        before, after = (
            (L * each.projected_solid_angles(normal)).sum() for L, each in ((radiance, view), (found, other))
        )
        assert after == pytest.approx(before, rel=4e-3)
    inside = other.solid_angles() > 0
    np.testing.assert_allclose(view.resampled(np.ones_like(radiance), other)[inside], 1.0, rtol=1e-10)


def test_estimates_keep_their_errors_when_they_are_converted():
    view, other = MAPS[0], MAPS[2]
    radiance = seen(view, sources=PANEL).radiance
    found = view.resampled(radiance, other)
    assert found.dims == ("face", "v", "u")
    before, after = (radiance * view.solid_angles()).sum(), (found * other.solid_angles()).sum()
    assert after.value == pytest.approx(before.value, rel=1e-10)
    assert after.error == pytest.approx(before.error, rel=1e-6)


# ---- views of a light field ----


def test_a_view_of_a_light_field_is_what_a_camera_sees_there():
    """Panels in the far plane with their edges at those of cells: then the light field is exact at its resolution."""
    panels = [
        tp.Source(
            tp.Rectangle(center=(0.5 * i - 0.5, 2, 0.5 * j - 0.25), normal=(0, -1, 0), width=0.5, height=0.5),
            tp.Lambertian(radiance=1.0 + 2 * ((i + j) % 2) + i),
        )
        for i in range(3)
        for j in range(2)
    ]
    field = tp.LightField(
        name="field",
        position=(0, 0, 0),
        direction=(0, 1, 0),
        distance=2.0,
        size=(0.6, 0.4),
        far_size=(1.5, 1.0),
        views=(3, 2),
        pixels=(12, 8),
    )
    radiance = seen(field, sources=panels, particles=1_000_000).radiance
    for place in ((0.0, 0.0, 0.0), (0.125, -0.5, 0.125)):  # behind the near plane, too
        distance = 2 - place[1]
        width = 1.0 / (1 if place[1] == 0 else 2)
        eye = tp.Camera(
            name="eye",
            position=place,
            direction=(0, 1, 0),
            field_of_view=2 * math.atan(width / 2 / distance),
            pixels=(4, 2) if place[1] == 0 else (2, 1),
        )
        found, true = field.view(radiance, eye), seen(eye, sources=panels, particles=1_000_000).radiance
        assert_alike(found - true, 0.0)
    away = tp.Camera(name="eye", position=(0, 0, 0), direction=(0, -1, 0), pixels=(2, 2))
    assert_refused(
        lambda: field.view(radiance.value, away), "camera must see the far plane through the near plane"
    )
    wide = replace(away, direction=(0, 1, 0), field_of_view=0.9, pixels=(4, 4))
    assert np.isnan(field.view(radiance.value, wide)).sum() == 12  # the rim


# ---- what is refused ----

REFUSED = {
    "lens must be 'pinhole' or": {"lens": "zoom"},
    "aperture is of no use with lens='pinhole'": {"aperture": 0.1},
    "width must be given with lens='orthographic'": {"lens": "orthographic"},
    "field_of_view is of no use with lens='orthographic'": {
        "lens": "orthographic",
        "width": 1.0,
        "field_of_view": 1.0,
    },
    "focal_length must be given": {"lens": "thin lens", "aperture": 0.1},
    "aperture must be the diameter in metres ... for f/2.8": {
        "lens": "thin lens",
        "aperture": 2.8,
        "focal_length": 0.05,
    },
    "focus must be above focal_length=0.5 m": {
        "lens": "thin lens",
        "aperture": 0.1,
        "focal_length": 0.5,
        "focus": 0.4,
    },
    "field_of_view must be in (0, pi)": {"field_of_view": math.pi},
    "field_of_view must be in (0, 2 pi]": {"lens": "fisheye", "field_of_view": 7.0},
}


@pytest.mark.parametrize("says", REFUSED)
def test_lenses_without_their_parameters_are_refused(says):
    assert_refused(lambda: tp.Camera(**{**AHEAD, **REFUSED[says]}), says)


def test_maps_without_use_for_a_parameter_and_light_fields_without_size_are_refused():
    where = {"name": "map", "position": (0, 0, 0)}
    assert_refused(
        lambda: tp.EnvironmentMap(**where, projection="globe"), "projection must be 'latitude-longitude' or"
    )
    assert_refused(
        lambda: tp.EnvironmentMap(**where, projection="cube", theta=4),
        "theta is of no use with projection='cube'",
    )
    assert_refused(
        lambda: tp.EnvironmentMap(**where, pixels=4),
        "pixels is of no use with projection='latitude-longitude'",
    )
    assert_refused(lambda: MAPS[0].projected_solid_angles((0, 0, 0)), "normal must be three numbers")
    field = {
        "name": "field",
        "position": (0, 0, 0),
        "direction": (0, 1, 0),
        "distance": 1.0,
        "size": (1, 1),
        "far_size": (1, 1),
    }
    assert_refused(lambda: tp.LightField(**{**field, "size": (1, 0)}), "size must be")
    assert_refused(
        lambda: tp.LightField(**{**field, "views": (4000, 4000), "pixels": (4000, 4000)}),
        "u x v x s x t must be",
    )
    assert_refused(
        lambda: camera("thin lens").solid_angles(), "pixels have no solid angle with lens='thin lens'"
    )
    lamp = tp.Source(tp.Point(position=(0, 3, 0)), tp.Isotropic(power=1.0))
    lit = run(
        tp.Scene([SKY, lamp], (), [tp.LightField(**{**field, "name": "field"}), camera("thin lens")]), 10_000
    )
    assert_refused(lambda: lit["field"].flux_in, "flux_in needs the direct light of each Point and Beam")
    assert_refused(lambda: lit["view"].irradiance, "irradiance needs the direct light of each Point and Beam")
    result = run(tp.Scene(SKY, (), camera("pinhole")), 1000)
    assert_refused(lambda: result["view"].irradiance, "irradiance needs the film of a lens")


def test_slivers_within_the_rim_of_a_round_image_are_as_certain_as_other_pixels():
    """A pixel of which the rim leaves a thousandth samples that thousandth alone."""
    scores = []
    for name, least in (("fisheye", 300), ("mirrored ball", 10)):
        view = tp.EnvironmentMap(name="map", position=(0, 0, 0), projection=name, pixels=101)
        share = view.cell_measures().values / np.diff(view.edges()["u"])[0] ** 2
        rim = (view.solid_angles() > 0) & (share < 0.01)
        assert rim.sum() > least
        radiance = seen(view, particles=26_000_000).radiance
        known = rim & (radiance.error > 0)
        assert np.abs((radiance.value - L)[known] / radiance.error[known]).max(initial=0.0) < 6  # few batches
        scores.append(np.abs(radiance.value[rim] / L - 1).max())
    assert max(scores) < 0.1, scores  # 2500 scores in a pixel, that vary by 100 % at most: 5 standard errors


def test_cells_of_light_fields_that_are_wider_than_far_have_the_throughput_of_the_closed_form():
    def cells(width):
        where = {"name": "field", "position": (0, 0, 0), "direction": (0, 1, 0), "distance": 1.0}
        field = tp.LightField(
            **where, size=(width, width), far_size=(1.4 * width, width), views=(1, 2), pixels=(2, 1)
        )
        return field.cell_measures().values.ravel() / width**4

    assert cells(1.0) == pytest.approx(cells(1.0 + 1e-9), rel=1e-7)
    assert cells(1e4).max() < 1e-7
