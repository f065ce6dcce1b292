"""What is thinner than rounding leaves of it is refused; what is a hundred times thicker is right."""

from __future__ import annotations

import pytest

import transport as tp
from transport.compile import surfaces

LIMIT = "must not differ by more than 1 : 1.1e[+]12"


def strip(width: float, aside: float) -> float:
    """What a strip of this width and length 1 absorbs of a beam so many half widths from its middle."""
    shape = tp.Rectangle(center=(0.3, -0.2, 0.7), width=width, height=1.0)
    start = (0.3 + aside * width / 2, -0.2, 1.7)
    beam = tp.Source(tp.Point(position=start), tp.Beam((0, 0, -1), power=1.0))
    scene = tp.Scene(beam, tp.Surface(shape, tp.Black(), "strip"))
    return tp.simulate(scene, particles=64, seed=1, progress=False).ledger["absorbed"].value


@pytest.mark.parametrize("width", [1e-8, 1e-10])
def test_a_strip_is_as_wide_as_told(width):
    assert strip(width, 0.999) == 1
    assert strip(width, 1.001) == 0


@pytest.mark.parametrize("width", [1e-12, 1e-14])
def test_a_strip_that_rounding_would_widen_is_refused(width):
    with pytest.raises(
        tp.SceneError, match=r"Surface 'strip': a flat surface here must be wider than .* got"
    ):
        strip(width, 0.5)


def test_without_that_care_light_beside_a_strip_is_absorbed(monkeypatch):
    """Planted: any width is taken."""
    monkeypatch.setattr(surfaces, "MAX_WIDENING", float("inf"))
    assert strip(1e-14, 1.1) == 1


def test_rings_and_triangles_are_judged_by_their_width():
    ring = tp.Disk(radius=1.0, inner_radius=1 - 1e-13)
    splinter = tp.Triangle(vertices=((0, 0, 0), (1, 0, 0), (0.5, 1e-13, 0)))
    lamp = tp.Source(tp.Point(position=(0, 0, 1)), tp.Isotropic(power=1.0))
    for shape in (ring, splinter):
        with pytest.raises(tp.SceneError, match="must be wider"):
            tp.simulate(tp.Scene(lamp, tp.Surface(shape, tp.Black())), particles=10, progress=False)


REFUSED = {
    "needle": (lambda: tp.Cylinder(radius=1e-13, height=1.0), LIMIT),
    "coin": (lambda: tp.Cylinder(radius=1.0, height=1e-13), LIMIT),
    "flat cone": (lambda: tp.Cone(radius=1.0, height=1e-15), LIMIT),
    "sharp cone": (lambda: tp.Cone(radius=1e-100, height=1.0), LIMIT),
    "deep dish": (lambda: tp.Paraboloid(focal_length=1e-139, radius=1.0), LIMIT),
    "flat dish": (lambda: tp.Paraboloid(focal_length=1e50, radius=1e-50), LIMIT),
    "tiny dish": (lambda: tp.Paraboloid(focal_length=1e-300, radius=1e-300), "squares .* must not vanish"),
    "bin at the pole": (lambda: tp.Directions(theta=(0, 1e-9, 1)), "theta bins must be at least .* wide"),
    "bin of the world": (lambda: tp.Directions(theta=(0, 1e-9, 1), frame="world"), "theta bins .*cone"),
    "bin of cosines": (lambda: tp.Directions(mu=(0, 1 - 1e-15, 1)), "mu bins must be at least"),
    "bin of a sphere": (lambda: tp.Directions.sphere(mu=(-1, 1 - 1e-15, 1)), "mu bins must be at least"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_has_no_digits_is_refused(case):
    make, words = REFUSED[case]
    with pytest.raises(tp.SceneError, match=words):
        make()


@pytest.mark.parametrize(
    "shape",
    [
        tp.Cylinder(center=(0.3, -0.2, 0.7), axis=(1, 2, 3), radius=1e-11, height=1.0),
        tp.Cone(center=(0.3, -0.2, 0.7), axis=(1, 2, 3), radius=1.0, height=1e-11),
        tp.Cone(center=(0.3, -0.2, 0.7), axis=(1, 2, 3), radius=1e-11, height=1.0),
        tp.Paraboloid(axis=(1, 2, 3), focal_length=1e10, radius=1.0),
    ],
    ids=["needle", "flat cone", "sharp cone", "flat dish"],
)
def test_light_that_leaves_the_outside_of_thin_bodies_is_gone(shape):
    wall = tp.Surface(shape, tp.Black(), "wall")
    lamp = tp.Source("wall", tp.Lambertian(power=1.0))
    ledger = tp.simulate(tp.Scene(lamp, wall), particles=2000, seed=1, progress=False).ledger
    assert ledger["escaped"].value == pytest.approx(1, rel=1e-14)


def fibre(radius: float) -> tp.Scene:
    """A turned can of glass, 1 m long, lit at its end."""
    axis, center = (1 / 14**0.5, 2 / 14**0.5, 3 / 14**0.5), (3.0, -2.0, 1.0)

    def beyond(way: float) -> tuple[float, ...]:
        return tuple(c + way * a for c, a in zip(center, axis, strict=True))

    glass = tp.Dielectric(1.5)
    side = tp.Surface(tp.Cylinder(center=center, axis=axis, radius=radius, height=1.0), glass, "fibre")
    ends = [
        tp.Surface(tp.Disk(center=beyond(end), normal=tuple(2 * end * a for a in axis), radius=radius), glass)
        for end in (0.5, -0.5)
    ]
    target = tp.Disk(center=beyond(0.5), normal=axis, radius=radius)
    back = tuple(-a for a in axis)
    lamp = tp.Source(
        tp.Disk(center=beyond(0.9), normal=back, radius=5 * radius), tp.Lambertian(power=1.0), aim=target
    )
    return tp.Scene(lamp, [side, *ends])


@pytest.mark.parametrize("radius", [1e-3, 1e-6, 1e-7])
def test_fibres_of_glass_know_what_is_in_them(radius):
    result = tp.simulate(fibre(radius), particles=2000, seed=1, progress=False)
    assert result.ledger["lost"].value == 0 and not result.warnings


@pytest.mark.parametrize("radius", [1e-8, 1e-9, 1e-11])
def test_fibres_in_which_rounding_loses_the_light_are_refused(radius):
    """Of radius 1e-8 a few of 2000 take glass for air; of 1e-9 the light never gets out."""
    with pytest.raises(tp.SceneError, match=r"'fibre': glass .* long must have a radius above .* got"):
        tp.simulate(fibre(radius), particles=10, progress=False)
