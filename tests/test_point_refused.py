"""What a point detector refuses: surfaces that it cannot see by, places on what sends, clocks and aims."""

from __future__ import annotations

import math

import pytest

import transport as tp
from tests.point_scenes import FOG, LAMP, T, filled
from transport.compile import points
from transport.compile.compiler import compile_scene
from transport.scene.phase_functions import Phase


def refused(message, sources=LAMP, surfaces=(), place=(1, 0, 0), tracking=None, **options):
    with pytest.raises(tp.SceneError) as raised:
        scene = tp.Scene(sources, surfaces, tp.PointDetector(place, "p"), **options)
        tp.simulate(scene, particles=100, progress=False, tracking=tracking)
    text = str(raised.value)
    assert text.startswith("PointDetector 'p'") and message in text, text


@pytest.mark.parametrize(
    "material",
    [
        tp.Mirror(),
        tp.Dielectric(1.5),
        tp.Glossy(0.2),
        tp.ThinLens(1.0),
        tp.Mixture({T: 0.5, tp.Black(): 0.5}),
    ],
)
def test_surfaces_that_it_cannot_see_by_are_refused_by_name(material):
    part = next(
        part for part in (*getattr(material, "parts", ((material,),)),) if not isinstance(part[0], tp.Black)
    )[0]
    disk = tp.Surface(tp.Disk(center=(5, 0, 0), radius=1.0), material, name="glass")
    refused(type(part).__name__, surfaces=[disk])
    refused("'glass'", surfaces=[disk])


def test_points_on_surfaces_and_sources_are_refused():
    wall = tp.Surface(tp.Sphere(radius=1.0), tp.Diffuse(0.5), name="wall")
    refused("must not lie on Surface 'wall'", surfaces=[wall], place=(0.6, 0.8, 0))
    refused("point source", place=(0, 0, 0))
    disk = tp.Source(tp.Disk(radius=2.0), tp.Lambertian(power=1.0))
    refused("must not lie on a source", sources=disk)
    tp.Scene(disk, detectors=tp.PointDetector((3, 0, 0), "beside"))


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_points_on_a_pencil_beam_are_refused(scale):
    """There the fluence rate is infinite: a code that goes on tells 1e72 of it.  Beside the beam, behind it, or in a wide one it is not."""
    lamp = tp.Source(tp.Point(position=(0, 0, scale)), tp.Beam((0.6, 0, -0.8), power=1.0))
    for way in (0.1, 1.0, 7.0):
        refused("infinite", sources=lamp, place=(0.6 * way * scale, 0, (1 - 0.8 * way) * scale))
    tp.Scene(lamp, detectors=tp.PointDetector((0.6 * scale, 1e-9 * scale, 0.2 * scale), "beside"))
    tp.Scene(lamp, detectors=tp.PointDetector((-0.6 * scale, 0, 1.8 * scale), "behind"))
    wide = tp.Source(
        tp.Disk(center=(0, 0, scale), normal=(0, 0, -1), radius=scale), tp.Beam((0, 0, -1), power=1.0)
    )
    tp.Scene(wide, detectors=tp.PointDetector((0, 0, 0), "in it"))


def test_clocks_aims_gas_and_forced_flights_are_refused():
    refused("steady", duration=1.0)
    aim = tp.Disk(center=(0, 0, 3), radius=1.0)
    refused("aim", sources=tp.Source(tp.Point(position=(0, 0, 0)), tp.Isotropic(power=1.0), aim=aim))
    gas = tp.Effusive(exitance=1.0, speed=1.0)
    refused("Effusive", sources=tp.Source(tp.Disk(radius=0.5), gas))
    box = filled(tp.Box(size=1.0), FOG)
    refused("forced", surfaces=[box], tracking=tp.Tracking(forced=True))


@pytest.mark.parametrize(
    "wrong, message",
    [
        ({"position": (0, 0), "name": "p"}, "position"),
        ({"position": (0, 0, math.inf), "name": "p"}, "position"),
        ({"position": (0, 0, 1)}, "name missing"),
        ({"position": (0, 0, 1), "name": None}, "name"),
        ({"position": (0, 0, 1), "name": "a.b"}, "name"),
        ({"center": (0, 0, 1), "name": "p"}, "'position'"),
    ],
)
def test_its_parameters_are_checked(wrong, message):
    with pytest.raises(tp.SceneError, match=message):
        tp.PointDetector(**wrong)


def test_the_passes_of_a_phase_function_get_its_parameter_not_its_mean_cosine(monkeypatch):
    monkeypatch.setattr(tp.HenyeyGreenstein, "parameter", property(lambda self: 0.25))
    lamp = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
    fog = tp.Medium(absorption=0.1, scattering=1.0, phase=tp.HenyeyGreenstein(0.5))
    plan = compile_scene(tp.Scene(lamp, (), tp.PointDetector((0, 0, 1), "p"), medium=fog))
    rows = [row for _, row in (*plan.phase_laws, *points.phase_densities(plan))]
    assert [float(row["g"]) for row in rows] == [0.25, 0.25]


@pytest.mark.parametrize("name", ["law", "max_density"])
def test_a_phase_function_unknown_to_the_engine_is_refused_and_not_taken_for_isotropic(name):
    class Unknown(Phase):
        def density(self, mu):
            return 0.25 / math.pi * (1 + 0 * mu)

    with pytest.raises(NotImplementedError, match="Unknown"):
        getattr(Unknown(), name)
