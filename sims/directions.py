"""Directions: they are counted, and the shares are solid angles.

Derivation.  A direction is a point of the unit sphere.  Between the polar angles θ and θ + dθ and the azimuths φ and
φ + dφ lies dω = sinθ dθ dφ (Hanrahan 2001, Stanford CS 348B, lecture 4, "Differential Solid Angles"), so that

    ∫ dω = 2π over a hemisphere, 4π over the sphere;    ∫ cosθ dω = π over a hemisphere.

An isotropic source sends the share dω/4π of its particles into dω, a diffuse one (the cosine law) cosθ dω/π.  So the
share of isotropic directions that meet a shape, times 4π, is the solid angle that it fills: an area that does not lie
on the sphere counts by its projection.  A disk of radius R seen from the distance d on its axis fills
2π (1 - d/√(R² + d²)), a square of side a 4 atan(a²/(2d √(4d² + 2a²))), a triangle what Van Oosterom and Strackee
(1983, eq. 8) say, an octant π/2, a face of a dodecahedron 4π/12 = 1.0472 sr: nearly a steradian, not one.

Arc and area.  An arc s on a circle of radius r is the angle θ = s/r, of 2π around; an area A on a sphere is Ω = A/r², of 4π: the
same arc twice as far fills half the angle, the same area a quarter of the solid angle.  The whole is counted in arcs of one radian
and areas of one steradian: all directions over those that meet one of them, which takes neither 2π nor 4π from the law.

One steradian "whatever its shape" (Akenine-Möller, Haines, Hoffman 2008, fig. 7.3): a cone of the half angle acos(1 − 1/2π), a
square of the half side √(q/(1 − q)) with q = sin(1/4), and a star, whose size is found from its solid angle, at the distance 1.

Footprint.  A narrow cone that meets a plane at the angle θ to its normal lights r² dω/cosθ of it.  The cone here is a pyramid of 60
sides of the half angle α = 2°; the corners of its footprint lie d cosθ/(n·ω) along its edges ω, and the area of that polygon tends
to π d² cos²θ sin²α cosα (cos²θ − sin²α)^(−3/2), the area of the ellipse, for many sides, and to 1/cosθ times that face on for small α.

Scene.  A point within a sphere whose inside is binned in θ and φ;  a tilted diffuse disk;  a dome of uniform radiance
over a disk and a ball, for the integrals as a receiver makes them;  a point and a shape that its directions are aimed
at (`tp.solid_angle`);  a point within a dodecahedron of 36 triangles.

Chi-square.  With N directions and K bins of the probabilities p, X² = Σ (counts - N p)²/(N p) has the expectation
K - 1, exactly and for any N (Pearson 1900).  Each batch gives one X²; their mean over K - 1 is an estimate of 1.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import transport as tp
from transport.analysis.solid_angle import solid_angle_from_run, solid_angle_scene
from transport.sims import (
    constant,
    curves_figure,
    figures,
    in_space,
    main,
    of_scene,
    one_of,
    require,
    sentence,
    sharp,
    where,
)
from transport.statistics.notation import with_thousands_spaces
from transport.theory import solid_angles
from transport.verification.experiment import Outcome

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Normalize

    from transport.viz.solid_panel import SolidPanel

law = (
    "dω = sinθ dθ dφ, ∫dω = 4π, ∫cosθ dω = π; Ω = 4π times the share of directions that meet a shape"
    " (Hanrahan 2001, Stanford CS 348B, lecture 4; Van Oosterom, Strackee 1983)"
)
question = "Do directions follow sinθ dθ dφ and cosθ sinθ dθ dφ, and what solid angles do shapes fill?"
particles = 8_000_000
run = {"sampling": "random"}  # χ² is of independent directions: those of nets are more even than chance

CAPS = (30, 60, 90, 120, 180)  # degrees
POLAR, AZIMUTHS = 24, 40  # bins
# bins of θ and φ in the picture of the hemisphere, and those that are outlined
COARSE = np.linspace(0, math.pi / 2, 9), np.linspace(0, 2 * math.pi, 21)
CELLS = (1, 0), (5, 0)
TILTED = (1.0, 2.0, -3.0)  # normal of the diffuse disk
BALL = 0.3  # radius of the ball and of the disk in the dome, whose own is 1
SHAPES = {  # seen from the origin; lengths in `size`
    "disk": tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=1.0),
    "square": tp.Rectangle(center=(0, 0, 1), normal=(0, 0, -1), width=1.0, height=1.0),
    "triangle": tp.Triangle(vertices=((-0.7, 1.1, 2.0), (1, 0.2, 1.5), (0.3, -1.3, 0.8))),
    "octant": tp.Triangle(vertices=((0, 1, 0), (1, 0, 0), (0, 0, 1))),
    "sliver": tp.Triangle(vertices=((1, 1e-4, 1), (1, 0, 1), (0, 1, 1))),
}
SUBJECTS = (
    "isotropic",
    "cosine law",
    "dome",
    *SHAPES,
    "dodecahedron",
    "arc and area",
    "one steradian",
    "footprint",
)
RADII = (1.0, 2.0, 4.0)  # of spheres with an arc of length 1 and an area of 1 on them
STERADIANS = {"cone": (0, 0, 1), "square": (1, 0, 0), "star": (-1, 0, 0)}  # and where they are seen
TILTS = (0, 30, 60, 75)  # degrees, of planes that a cone meets
SIDES, HALF_ANGLE = 60, math.radians(2)  # of the cone
POINTS, INNER = 5, 0.4  # tips of the star, radius of its inner corners over the outer
GROWTH = "footprint / face on"
FACE, FACES = "a dodecahedron's face", "its twelve faces"
# from the viewer to a drawn shape, and its way on the page
SLANT, UPWARD = math.radians(36), math.radians(35)
SMALL = 1e-3  # sr, below which a solid angle is written in µsr
CHI_SQUARE = "χ²/(K − 1)"
ONTO_BALL, ONTO_DISK, ONTO_BACK = "∫dω, onto a ball", "∫cosθ dω, onto a disk", "∫cosθ dω, onto its back"


def cases() -> list[dict[str, object]]:
    footprints = [{"subject": "footprint", "tilt": angle * tp.deg} for angle in TILTS]
    return [*({"subject": subject} for subject in SUBJECTS[:-1]), *footprints]


def scene(subject: str = "isotropic", power: float = 1.0, size: float = 1.0, tilt: float = 0.0) -> tp.Scene:
    """What directions are counted of.

    power [W] of the source;  size: what all lengths are multiplied by [m];  tilt [rad] of the plane that a cone meets.
    """
    one_of("directions", subject=(subject, SUBJECTS))
    point = tp.Source(tp.Point(), tp.Isotropic(power=power))
    match subject:
        case "isotropic":
            sky = tp.Positions(u=2 * POLAR, v=AZIMUTHS)
            return tp.Scene(
                point, detectors=tp.Detector(tp.Sphere(radius=size), "sky", "inside", positions=sky)
            )
        case "cosine law":
            disk = tp.Disk(normal=TILTED, radius=size)
            leaving = tp.Detector(disk, "leaving", directions=tp.Directions(theta=POLAR, phi=AZIMUTHS))
            return tp.Scene(tp.Source(disk, tp.Lambertian(power=power)), detectors=leaving)
        case "dome":
            center, radius = (0, 0.2 * size, 0.4 * size), BALL * size
            dome = tp.Source(tp.Sphere(radius=size), tp.Lambertian(power=power), side="inside")
            shapes = {
                "ball": tp.Sphere(center=center, radius=radius),
                "disk": tp.Disk(center=center, radius=radius),
            }
            return tp.Scene(dome, detectors=[tp.Detector(shape, name) for name, shape in shapes.items()])
        case "dodecahedron":
            faces = solid_angles.dodecahedron_faces(size)
            fans = [face[[0, i, i + 1]] for face in faces for i in (1, 2, 3)]  # normals outwards
            triangles = [tp.Triangle(vertices=corners) for corners in fans]
            return tp.Scene(point, detectors=[*map(tp.Detector, triangles, _names())])
        case "arc and area":
            return tp.Scene(point, detectors=_arcs_and_areas(size))
        case "one steradian":
            return tp.Scene(point, detectors=[tp.Detector(s, n, "back") for n, s in steradians(size).items()])
        case "footprint":
            must = "from 0 to below pi/2 less the cone's half angle"
            require("directions", tilt=(tilt, 0 <= tilt < math.pi / 2 - HALF_ANGLE, must))
            return solid_angle_scene(tp.Polygon(vertices=size * footprint(tilt)), (0, 0, 0), power)
    return solid_angle_scene(_scaled(SHAPES[subject], size), (0, 0, 0), power)


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    names = list(result)
    if names == ["sky"]:
        return _law_rows(result, sky_shares(result), isotropic_probabilities(), 4 * math.pi, _cap)
    if names == ["leaving"]:
        return _law_rows(result, leaving_shares(result), cosine_probabilities(), math.pi, _projected)
    if names == ["ball", "disk"]:
        return _dome_rows(result)
    if names == list(STERADIANS):
        return _steradian_rows(result)
    if names[0].startswith(ARC):
        return _arc_rows(result)
    if len(names) > 1:
        return _dodecahedron_rows(result)
    found = solid_angle_from_run(result)
    shape = result[names[0]].detector.shape
    return {"solid angle": found} | (
        _footprint_row(result, found, shape) if isinstance(shape, tp.Polygon) else {}
    )


@of_scene(scene)
def exact(subject: str, tilt: float) -> dict[str, float]:
    match subject:
        case "isotropic":
            filled = solid_angles.cap_solid_angle(np.radians(CAPS))
            return dict(zip(map(_cap, CAPS), filled.tolist(), strict=True)) | {CHI_SQUARE: 1.0}
        case "cosine law":
            within = [angle for angle in CAPS if angle <= 90]
            filled = solid_angles.cap_projected_solid_angle(np.radians(within))
            return dict(zip(map(_projected, within), filled.tolist(), strict=True)) | {CHI_SQUARE: 1.0}
        case "dome":
            return {ONTO_BALL: 4 * math.pi, ONTO_DISK: math.pi, ONTO_BACK: math.pi}
        case "dodecahedron":
            return {FACE: solid_angles.DODECAHEDRON_FACE, FACES: 4 * math.pi}
        case "arc and area":
            arcs = {_arc(r): 1 / r for r in RADII}
            areas = {_cap_of_area(r): 1 / r**2 for r in RADII}
            return arcs | areas | {CIRCLE: 2 * math.pi, WHOLE_SPHERE: 4 * math.pi}
        case "one steradian":
            alike = {f"{name} / {next(iter(STERADIANS))}": 1.0 for name in list(STERADIANS)[1:]}
            return dict.fromkeys(STERADIANS, 1.0) | alike
        case "footprint":
            filled = solid_angles.regular_polygon_solid_angle(SIDES, math.tan(HALF_ANGLE), 1.0)
            return {"solid angle": filled, GROWTH: area_of(footprint(tilt)) / area_of(footprint(0.0))}
    match shape := SHAPES[subject]:
        case tp.Disk():
            filled = solid_angles.disk_solid_angle(shape.radius, shape.center[2])
        case tp.Rectangle():
            filled = solid_angles.rectangle_solid_angle(shape.width, shape.height, shape.center[2])
        case _:
            filled = solid_angles.triangle_solid_angle(shape.vertices)
    return {"solid angle": float(filled)}


# ---- the laws of directions ----


def isotropic_probabilities() -> np.ndarray:
    """Of the bins of the sky, (2 POLAR, AZIMUTHS): (cosθ1 - cosθ2)/2 (φ2 - φ1)/2π."""
    rings = -np.diff(np.cos(np.linspace(0, math.pi, 2 * POLAR + 1))) / 2
    return np.outer(rings, np.full(AZIMUTHS, 1 / AZIMUTHS))


def cosine_probabilities() -> np.ndarray:
    """Of the bins of the hemisphere, (POLAR, AZIMUTHS): (sin²θ2 - sin²θ1) (φ2 - φ1)/2π."""
    rings = np.diff(np.sin(np.linspace(0, math.pi / 2, POLAR + 1)) ** 2)
    return np.outer(rings, np.full(AZIMUTHS, 1 / AZIMUTHS))


def sky_shares(result: tp.Result) -> tp.EstimateArray:
    """Share of the directions in each bin of the sky."""
    return result["sky"].counts / constant(result, result.particles, "1")


def leaving_shares(result: tp.Result) -> tp.EstimateArray:
    """Share of the directions in each bin above the diffuse disk."""
    leaving = result["leaving"]
    theta, phi = (leaving.intensity_out.coords[name] for name in ("theta", "phi"))
    plain = solid_angles.bin_solid_angles(np.cos(theta[::-1]), phi)[::-1]
    return leaving.intensity_out * plain * constant(result, 1.0, "sr") / result.ledger["emitted"]


def chi_square(shares: tp.EstimateArray, probabilities: np.ndarray) -> tp.Estimate:
    """X²/(K - 1) as the mean over batches; of right directions its expectation is 1, whatever their number."""
    expected = shares.run.sizes[:, None, None] * probabilities
    counts = shares.run.sizes[:, None, None] * shares.values
    values = ((counts - expected) ** 2 / expected).sum(axis=(1, 2)) / (probabilities.size - 1)
    return tp.Estimate(values, shares.run, "1")


def _law_rows(
    result: tp.Result, shares: tp.EstimateArray, probabilities: np.ndarray, whole: float, name
) -> dict[str, tp.Estimate]:
    """The directions within each cap's angle, times what all of them make [sr], and χ² of all bins."""
    rings, full = shares.sum("phi" if "phi" in shares.dims else "v"), constant(result, whole, "sr")
    step = 90 / POLAR
    caps = [angle for angle in CAPS if angle <= len(rings) * step]
    rows = {name(angle): rings[: round(angle / step)].sum() * full for angle in caps}
    rows[name(caps[-1])] = sharp(rows[name(caps[-1])], of=full)
    return rows | {CHI_SQUARE: chi_square(shares, probabilities)}


def _cap(angle: float) -> str:
    return f"∫dω, θ ≤ {angle}°"


def _projected(angle: float) -> str:
    return f"∫cosθ dω, θ ≤ {angle}°"


# ---- receivers and shapes ----


def _dome_rows(result: tp.Result) -> dict[str, tp.Estimate]:
    """Fluence rate and irradiance over the dome's radiance, which is its exitance over π."""
    [source], ball, disk = result.scene.sources, result["ball"], result["disk"]
    radiance = result.ledger["emitted"] / constant(result, math.pi * source.shape.area, "m^2 sr")
    section = constant(result, math.pi * ball.detector.shape.radius**2, "m^2")
    return {
        ONTO_BALL: ball.flux_in / section / radiance,
        ONTO_DISK: disk.irradiance / radiance,
        ONTO_BACK: disk.exitance / radiance,
    }


def _dodecahedron_rows(result: tp.Result) -> dict[str, tp.Estimate]:
    full = constant(result, 4 * math.pi, "sr")
    faces = [share * full for share in face_shares(result)]
    return {FACE: faces[0], FACES: sharp(sum(faces), of=full)}


def face_shares(result: tp.Result) -> list[tp.Estimate]:
    """Share of the directions that leave through each face of the dodecahedron."""
    triangles = [result[name].flux_out / result.ledger["emitted"] for name in _names()]
    return [sum(triangles[i : i + 3]) for i in range(0, len(triangles), 3)]


# ---- arcs, areas, steradians, footprints ----

ARC, AREA = "arc", "area"
CIRCLE, WHOLE_SPHERE = "θ of a full circle, arcs of s = r", "Ω of a full sphere, areas of A = r²"


def _arc(radius: float) -> str:
    return f"θ of an arc of 1, r = {radius:g}"


def _cap_of_area(radius: float) -> str:
    return f"Ω of an area of 1, r = {radius:g}"


def _arcs_and_areas(size: float) -> list[tp.Detector]:
    """On each sphere a sector of azimuth whose arc at the equator is 1, and a cap whose area is 1."""
    detectors = []
    for radius in RADII:
        sphere, half_angle = tp.Sphere(radius=size * radius), math.acos(1 - 1 / (2 * math.pi * radius**2))
        for word, places in (
            (ARC, tp.Positions(v=(0, 1 / radius))),
            (AREA, tp.Positions(u=(0, half_angle))),
        ):
            detectors.append(tp.Detector(sphere, f"{word} at {radius:g}", "inside", positions=places))
    return detectors


def _arc_rows(result: tp.Result) -> dict[str, tp.Estimate]:
    all_of_them = constant(result, result.particles, "1")
    around, sphere = constant(result, 2 * math.pi, "rad"), constant(result, 4 * math.pi, "sr")
    arcs, areas = (
        {r: result[f"{word} at {r:g}"].counts.sum() / all_of_them for r in RADII} for word in (ARC, AREA)
    )
    return {
        **{_arc(r): share * around for r, share in arcs.items()},
        **{_cap_of_area(r): share * sphere for r, share in areas.items()},
        CIRCLE: constant(result, 1.0, "rad") / arcs[1.0],
        WHOLE_SPHERE: constant(result, 1.0, "sr") / areas[1.0],
    }


@lru_cache(maxsize=1)
def star_radius() -> float:
    """Radius of the tips of a star at the distance 1 that fills one steradian."""
    from scipy.optimize import brentq

    return brentq(lambda radius: solid_angles.polygon_solid_angle(_star(radius)) - 1, 0.5, 5.0, xtol=1e-15)


def _star(radius: float) -> np.ndarray:
    """Corners at z = 1, counterclockwise seen from above."""
    turn = math.pi * np.arange(2 * POINTS) / POINTS
    reach = radius * np.where(np.arange(2 * POINTS) % 2, INNER, 1.0)
    return np.stack([reach * np.cos(turn), reach * np.sin(turn), np.ones_like(turn)], axis=1)


def steradians(size: float = 1.0) -> dict[str, tp.Disk | tp.Rectangle | tp.Polygon]:
    """Shapes of one steradian, seen from the origin."""
    alpha, q = math.acos(1 - 1 / (2 * math.pi)), math.sin(0.25)
    side = 2 * size * math.sqrt(q / (1 - q))
    star = _star(star_radius())[:, [2, 0, 1]] * (-1, -1, 1)  # at x = -1, its front outwards
    return {
        "cone": tp.Disk(center=(0, 0, size), normal=(0, 0, 1), radius=size * math.tan(alpha)),
        "square": tp.Rectangle(center=(size, 0, 0), normal=(1, 0, 0), width=side, height=side),
        "star": tp.Polygon(vertices=size * star),
    }


def _steradian_rows(result: tp.Result) -> dict[str, tp.Estimate]:
    full = constant(result, 4 * math.pi, "sr") / result.ledger["emitted"]
    shares = {name: result[name].flux_in * full for name in STERADIANS}
    first = next(iter(STERADIANS))
    return shares | {f"{name} / {first}": shares[name] / shares[first] for name in list(STERADIANS)[1:]}


def footprint(tilt: float) -> np.ndarray:
    """Corners of what a narrow cone about +z meets of a plane through (0, 0, 1) that is tilted about the y axis."""
    turn = 2 * math.pi * np.arange(SIDES) / SIDES
    rim = [
        np.sin(HALF_ANGLE) * np.cos(turn),
        np.sin(HALF_ANGLE) * np.sin(turn),
        np.full(SIDES, math.cos(HALF_ANGLE)),
    ]
    ways = np.stack(rim, axis=1)[::-1]  # so that the front looks back to the origin
    normal = np.array([math.sin(tilt), 0, math.cos(tilt)])
    return ways * (math.cos(tilt) / (ways @ normal))[:, None]


def area_of(corners: np.ndarray) -> float:
    """Area of a flat polygon: half its vector area."""
    spokes = corners - corners[0]
    return float(np.linalg.norm(np.cross(spokes[1:-1], spokes[2:]).sum(axis=0)) / 2)


def _footprint_row(result: tp.Result, found: tp.Estimate, shape: tp.Polygon) -> dict[str, tp.Estimate]:
    """Area of the footprint per steradian, over that face on."""
    size = shape.vertices[0][2] / footprint(math.acos(min(abs(shape.normal[2]), 1.0)))[0, 2]
    face_on = area_of(footprint(0.0)) / solid_angles.regular_polygon_solid_angle(
        SIDES, math.tan(HALF_ANGLE), 1.0
    )
    return {GROWTH: constant(result, shape.area / size**2 / face_on, "sr") / found}


def _names() -> list[str]:
    return [f"face {face}, triangle {part}" for face in range(1, 13) for part in (1, 2, 3)]


def _scaled(shape, size: float):
    """The shape with all lengths multiplied."""
    lengths = ("center", "radius")
    match shape:
        case tp.Rectangle():
            lengths = ("center", "width", "height")
        case tp.Triangle():
            lengths = ("vertices",)
    return replace(shape, **{name: size * np.array(getattr(shape, name)) for name in lengths})


# ---- answer and pictures ----


def verdict(outcomes: list[Outcome]) -> str:
    found, said = {o.given["subject"]: o for o in outcomes}, []
    if laws := [found[name][CHI_SQUARE].estimate for name in ("isotropic", "cosine law") if name in found]:
        said.append(f"directions follow their laws, χ²/(K − 1) = {' and '.join(map(str, laws))}")
    if "dome" in found:
        integrals = ", ".join(str(row.estimate) for row in found["dome"].rows)
        said.append(f"a receiver's integrals are {integrals}")
    if shapes := [f"{found[name].rows[0].estimate} ({name})" for name in SHAPES if name in found]:
        said.append(f"by counting shapes fill {', '.join(shapes)}")
    if "dodecahedron" in found:
        said.append(f"a face of a dodecahedron fills {found['dodecahedron'][FACE].estimate}, not 1 sr")
    if "arc and area" in found:
        arc, area = (found["arc and area"][name(RADII[1])].estimate for name in (_arc, _cap_of_area))
        said.append(f"twice as far an arc of 1 fills {arc} and an area of 1 fills {area}")
    if "one steradian" in found:
        alike = ", ".join(f"{name} {found['one steradian'][name].estimate}" for name in STERADIANS)
        said.append(f"one steradian has the same counts whatever its shape: {alike}")
    for outcome in where(subject="footprint")(outcomes)[-1:]:
        tilt = math.degrees(outcome.given["tilt"])
        said.append(
            f"on a plane at {tilt:.3g}° a cone's footprint is {outcome[GROWTH].estimate} times that face on"
        )
    return sentence(*said)


def draw_shapes(outcomes: list[Outcome], path: Path, note: str) -> None:
    """Each shape and its shadow on the unit sphere about the point that sees it, with the solid angle that was counted."""
    from transport.viz.style import figure

    columns = min(3, len(outcomes))
    rows = -(-len(outcomes) // columns)
    with figure(
        (6.2 * columns, 6.2 * rows + 1.2), "A shape counts by its shadow on the unit sphere", note, path
    ) as page:
        grid = page.subplots(rows, columns, squeeze=False)
        for axes, outcome in zip(grid.flat, outcomes, strict=False):
            _draw_shape(axes, outcome)
        for axes in list(grid.flat)[len(outcomes) :]:
            axes.remove()


def _outline(shape: tp.Disk | tp.Rectangle | tp.Triangle | tp.Polygon | np.ndarray) -> np.ndarray:
    """Points along the rim of a flat shape, or of corners, closed (N, 3)."""
    match shape:
        case tp.Disk():
            turn = np.linspace(0, 2 * math.pi, 201)[:, None]
            u, v, _ = np.array(shape.frame)
            return np.array(shape.center) + shape.radius * (np.cos(turn) * u + np.sin(turn) * v)
        case tp.Rectangle():
            u, v = np.array(shape.frame[:2]) * ([shape.width / 2], [shape.height / 2])
            corners = np.array(shape.center) + (u + v, v - u, -u - v, u - v)
        case np.ndarray():
            corners = shape
        case _:
            corners = np.array(shape.vertices)
    along = np.linspace(0, 1, 40, endpoint=False)[:, None]
    sides = [a + along * (b - a) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)]
    return np.concatenate([*sides, sides[0][:1]])


def _draw_shape(axes, outcome: Outcome) -> None:
    """The unit sphere from outside, the shape, its shadow, and rays from the middle of the sphere to the shape's rim."""
    from matplotlib.colors import to_rgb

    from transport.viz.style import BLUE, INK, MUTED, ORANGE, VERMILLION
    from transport.viz.wording import number_text

    subject, row = outcome.given["subject"], outcome.rows[0]
    face = subject == "dodecahedron"
    rim = _outline(solid_angles.dodecahedron_faces(1.0)[0] if face else SHAPES[subject])
    shadow = rim / np.linalg.norm(rim, axis=1, keepdims=True)
    screen = _screen(shadow[:-1].mean(axis=0))
    turn = np.linspace(0, 2 * math.pi, 181)
    axes.fill(np.cos(turn), np.sin(turn), fc="#eef3f7", ec=MUTED, lw=2)
    for tilt in np.radians(
        [-60, -30, 0, 30, 60]
    ):  # circles of latitude and of longitude, seen from the equator
        axes.plot([-math.cos(tilt), math.cos(tilt)], [math.sin(tilt)] * 2, color="#c9d3db", lw=1)
        axes.plot(math.sin(tilt) * np.cos(turn), np.sin(turn), color="#c9d3db", lw=1)
    axes.fill(*(shadow @ screen).T, fc=ORANGE, ec=VERMILLION, lw=4, zorder=3)
    if face:
        for other in solid_angles.dodecahedron_faces(1.0):
            if (other.mean(axis=0) @ np.cross(*screen.T)) > 0:
                axes.plot(*(other[[0, 1, 2, 3, 4, 0]] @ screen).T, color=BLUE, lw=1.6, zorder=2)
    axes.fill(*(rim @ screen).T, fc=(*to_rgb(BLUE), 0.16), lw=0, zorder=2.5)
    axes.plot(*(rim @ screen).T, color=BLUE, lw=4, zorder=4)
    corners = rim[:-1][:: max(1, (len(rim) - 1) // (4 if subject == "disk" else len(rim) // 40))]
    for corner in corners:
        far = corner * max(1.0, 1 / np.linalg.norm(corner))
        axes.plot(*np.stack([0 * far[:2], far @ screen]).T, color=INK, lw=1.4, zorder=5)
    axes.plot(0, 0, "o", color=INK, ms=11, zorder=6)
    scale, unit = (1.0, "sr") if row.exact > SMALL else (1e6, "µsr")
    name = "dodecahedron's face" if face else subject
    words = f"{name}\nΩ = {number_text(row.estimate, scale)} {unit}\nexact {scale * row.exact:.5g} {unit}"
    axes.text(-1.05, 1.84, words, fontsize=21, va="top", linespacing=1.35)
    axes.set(aspect="equal", xlim=(-1.05, 1.85), ylim=(-1.05, 1.84))
    axes.axis("off")


def _screen(middle: np.ndarray) -> np.ndarray:
    """Axes of the drawing to the right and up (3, 2), such that this direction points to the upper right, towards the viewer."""
    ahead = middle / np.linalg.norm(middle)
    aside = np.cross(ahead, (0, 1, 0) if abs(ahead[1]) < 0.9 else (1, 0, 0))
    aside /= np.linalg.norm(aside)
    over = np.cross(aside, ahead)
    # In the frame (aside, over, ahead) the viewer stands to the lower left.
    viewer = np.array(
        [-math.sin(SLANT) * math.cos(UPWARD), -math.sin(SLANT) * math.sin(UPWARD), math.cos(SLANT)]
    )
    right = np.cross((0, 1, 0), viewer)
    right /= np.linalg.norm(right)
    return (np.stack([right, np.cross(viewer, right)]) @ np.stack([aside, over, ahead])).T


def draw_caps(outcomes: list[Outcome], path: Path, note: str) -> None:
    """Integrals over caps against their half angle, counted at a source, and at 90° or 180° by a receiver in a dome."""
    from transport.viz.curves import Series, plot_curves
    from transport.viz.style import figure

    found = {o.given["subject"]: o for o in outcomes}
    panels = {
        "∫dω = 2π(1 − cosθ)": (
            "isotropic", {ONTO_BALL: 180.0}, _cap, solid_angles.cap_solid_angle, "πθ², wrong", lambda theta: math.pi * theta**2
        ),
        "∫cosθ dω = π sin²θ": (
            "cosine law", {ONTO_DISK: 90.0, ONTO_BACK: 90.0}, _projected, solid_angles.cap_projected_solid_angle,
            "without the cosine", solid_angles.cap_solid_angle,
        ),
    }  # fmt: skip
    chosen = {words: each for words, each in panels.items() if "dome" in found or each[0] in found}
    with figure((9.5 * len(chosen), 9.5), "How many steradians a cap holds", note, path) as page:
        grid = page.subplots(2, len(chosen), squeeze=False, sharex="col", height_ratios=(2.7, 1))
        for column, (words, each) in zip(grid.T, chosen.items(), strict=True):
            subject, whole, name, law_of, wrong, guide = each
            series = {}
            if subject in found:
                angles = [angle for angle in CAPS if name(angle) in found[subject]]
                rows = [found[subject][name(angle)].estimate for angle in angles]
                series["counted by cap"] = Series(angles, rows, lambda x, f=law_of: f(np.radians(x)))
            if "dome" in found:
                rows = [found["dome"][row].estimate for row in whole]
                places = list(whole.values())
                series["received in a dome"] = Series(places, rows, expected=law_of(np.radians(places)))
            end = 180 if subject == "isotropic" else 90
            plot_curves(
                series, ax=tuple(column), xlabel="half angle θ of the cap  [deg]", ylabel="steradians", span=(0, end),
                guides={wrong: lambda x, f=guide: f(np.radians(x))}, legend="upper left",
            )  # fmt: skip
            column[0].set_title(words)
            column[0].set(xlim=(0, 1.03 * end), xticks=range(0, end + 1, end // 6))


@curves_figure(xlabel="polar angle θ  [deg]", ylabel="share of the directions per degree")
def draw_law(outcomes: list[Outcome]) -> dict[str, object]:
    """Share of the directions per degree of polar angle, against the law."""
    result = outcomes[0].result
    if "sky" in result:
        shares, expected, reach = sky_shares(result).sum("v"), isotropic_probabilities(), 180
        curve, title = lambda theta: np.sin(theta) / 2, "Isotropic directions: sinθ dθ dφ / 4π"
    else:
        shares, expected, reach = leaving_shares(result).sum("phi"), cosine_probabilities(), 90
        curve, title = lambda theta: np.sin(2 * theta), "The cosine law: cosθ sinθ dθ dφ / π"
    per_degree, edges = POLAR / 90, np.linspace(0, reach, len(shares) + 1)
    fine = np.linspace(0, reach, 721)
    law = fine, curve(np.radians(fine)) * math.pi / 180
    return {
        "series": (edges, shares * per_degree, law, expected.sum(axis=1) * per_degree),
        "title": title,
    }


def draw_hemisphere(outcomes: list[Outcome], path: Path, note: str) -> None:
    """The upper hemisphere in coarse bins: their counts, and those over sinθ dθ dφ; two bins with their numbers."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    from transport.viz.solid_panel import SolidPanel
    from transport.viz.style import SEQUENTIAL, figure

    counts = outcomes[0].result["sky"].counts.value[:POLAR]
    counts = counts.reshape(len(COARSE[0]) - 1, -1, len(COARSE[1]) - 1, AZIMUTHS // (len(COARSE[1]) - 1)).sum(
        axis=(1, 3)
    )
    sizes = np.outer(-np.diff(np.cos(COARSE[0])), np.diff(COARSE[1]))
    panels = {
        "counted per bin": (counts, "directions per bin", with_thousands_spaces),
        "the same counts over sinθ dθ dφ": (
            counts / sizes / 1e3,
            "thousand directions per sr",
            "{:.1f}".format,
        ),
    }
    with figure((19, 9.6), "dω = sinθ dθ dφ: the same dθ and dφ hold less near the pole", note, path) as page:
        for axes, (words, (values, label, number)) in zip(page.subplots(1, 2), panels.items(), strict=True):
            norm = Normalize(0, 1.05 * values.max())
            panel = SolidPanel(viewer=(math.cos(math.pi / 20), math.sin(math.pi / 20), 0.8))
            _place_bins(panel, values, norm, number)
            panel.show(axes)
            axes.set_title(words)
            page.colorbar(ScalarMappable(norm, SEQUENTIAL), ax=axes, shrink=0.75, pad=0.02).set_label(label)


def _place_bins(
    panel: SolidPanel, values: np.ndarray, norm: Normalize, number: Callable[[float], str]
) -> None:
    """The hemisphere coloured by bin, two bins of it outlined with their numbers, one with the words of its sides."""
    from transport.viz.solid_panel import LABEL
    from transport.viz.style import BLUE, MUTED, SKY

    def at(theta: np.ndarray, phi: np.ndarray, radius: float = 1.0) -> np.ndarray:
        theta, phi = np.broadcast_arrays(theta, phi)
        return radius * np.stack(
            [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1
        )

    thetas, phis = COARSE
    fine = np.linspace(0, math.pi / 2, POLAR + 1)[:, None], np.linspace(phis[0], phis[-1], 3 * AZIMUTHS + 1)
    repeats = [(len(each) - 1) // n for each, n in zip((fine[0], fine[1]), values.shape, strict=True)]
    panel.bins(at(*fine), values.repeat(repeats[0], axis=0).repeat(repeats[1], axis=1), norm)
    for theta in thetas[1:]:
        panel.line(at(theta, fine[1], 1.002), MUTED, 0.003)
    for phi in phis[:-1]:
        panel.line(at(fine[0][:, 0], phi, 1.002), MUTED, 0.003)
    steps = np.linspace(0, 1, 12)
    for i, j in CELLS:
        theta, phi = (edges[k] + steps * (edges[k + 1] - edges[k]) for edges, k in ((thetas, i), (phis, j)))
        sides = [
            at(theta[0], phi, 1.005),
            at(theta, phi[-1], 1.005),
            at(theta[-1], phi, 1.005),
            at(theta, phi[0], 1.005),
        ]
        for side in sides:
            panel.line(side, SKY, 0.014)
        panel.text(at(theta[6], phi[6]), number(values[i, j]), **LABEL)
    panel.text(sides[1][6] + 0.12 * (sides[1][6] - sides[3][6]), "dθ", ha="left", color=BLUE, **LABEL)
    panel.text(sides[2][6] - (0, 0, 0.1), "sinθ dφ", color=BLUE, **LABEL)


def draw_radiance(outcomes: list[Outcome], **out: object) -> None:
    """The directions of the cosine law over cosθ dω: the same radiance up to the horizon."""
    from transport.viz.maps import plot_map

    seen = outcomes[0].result["leaving"]
    level = outcomes[0].result.ledger["emitted"].value / (math.pi * seen.area)
    title = "The cosine law, divided by cosθ dω: the same radiance in all directions"
    words = {"quantity": "radiance_out", "label": "radiance L", "title": title}
    plot_map(seen, exact=lambda theta, phi: level + 0 * theta, cut=True, **words, **out)


def draw_arcs(outcomes: list[Outcome], path: Path, note: str) -> None:
    """The same arc on three circles, and the angle and the solid angle by distance."""
    from transport.viz.style import BLUE, INK, MUTED, VERMILLION, figure, tick_log

    outcome = outcomes[0]
    with figure((16, 12), "θ = s/r and Ω = A/r²: a full circle has 2π, a full sphere 4π", note, path) as page:
        grid = page.add_gridspec(2, 2, width_ratios=(1.3, 1), height_ratios=(1, 1.1))
        left, right = page.add_subplot(grid[0, 0]), page.add_subplot(grid[:, 1])
        _draw_wholes(page.add_subplot(grid[1, 0]), outcome)
        for radius in RADII:
            angle = np.linspace(-0.5, 0.5, 50) / radius
            left.plot(radius * np.cos(angle), radius * np.sin(angle), color=BLUE, lw=7, solid_capstyle="butt")
            for end in (-0.5, 0.5):
                left.plot(
                    [0, radius * math.cos(end / radius)],
                    [0, radius * math.sin(end / radius)],
                    color=MUTED,
                    lw=1.8,
                )
            left.text(
                radius + 0.04,
                0.56,
                f"r = {radius:g}\nθ = {1 / radius:g} rad\nΩ = {1 / radius**2:g} sr",
                ha="center",
                va="bottom",
                fontsize=15,
            )
        left.plot(0, 0, "o", color=INK, ms=11)
        left.set(aspect="equal", xlim=(-0.2, 4.7), ylim=(-0.9, 1.9), xticks=[], yticks=[])
        left.text(2.4, -0.85, "arc s = 1, or a cap of the area A = 1", color=BLUE, ha="center")
        left.spines[:].set_visible(False)
        fine = np.array([0.8, 5.0])
        for name, power, colour, label in (
            (_arc, 1, BLUE, "θ = s/r  [rad]"),
            (_cap_of_area, 2, VERMILLION, "Ω = A/r²  [sr]"),
        ):
            rows = [outcome[name(r)].estimate for r in RADII]
            right.plot(fine, fine**-power, color=colour, lw=3)
            right.errorbar(
                RADII,
                [r.value for r in rows],
                [r.error for r in rows],
                fmt="o",
                ms=13,
                color=colour,
                label=label,
            )
        right.plot(fine, fine**-3, "--", color=MUTED, lw=2.5, label="if it fell with 1/r³")
        right.set(
            xscale="log",
            yscale="log",
            xlabel="distance r",
            ylabel="what the directions fill",
            xlim=fine,
            ylim=(0.02, 2),
        )
        tick_log(right.xaxis), tick_log(right.yaxis)
        right.legend(loc="lower left")


def _draw_wholes(axes: Axes, outcome: Outcome) -> None:
    """A circle cut into arcs of one radian and a rest, a sphere with a cap of one steradian, and what was counted of both."""
    from matplotlib.patches import Circle, Wedge

    from transport.viz.exhibits import bare_panel
    from transport.viz.style import BLUE, INK, MUTED, SKY, VERMILLION
    from transport.viz.wording import number_text

    middle, ends = 3.1, np.degrees([*range(7), 2 * math.pi])  # of the sphere; of the arcs
    for k, (low, high) in enumerate(pairwise(ends)):
        colour = VERMILLION if k == 6 else (BLUE, SKY)[k % 2]
        axes.add_patch(Wedge((0, 0), 1, low, high, width=0.1, fc=colour, lw=0))
        axes.plot([0, math.cos(k)], [0, math.sin(k)], color=MUTED, lw=1.8)
        at, words, out = math.radians((low + high) / 2), str(k + 1), 1.17
        if k == 6:
            words, out = f"{2 * math.pi - 6:.3f}", 1.32
        axes.text(out * math.cos(at), out * math.sin(at), words, color=colour, ha="center", va="center")
    axes.add_patch(Circle((middle, 0), 1, fc="#eef3f7", ec=MUTED, lw=2))
    turn, cap = np.linspace(0, 2 * math.pi, 181), math.acos(1 - 1 / (2 * math.pi))
    for tilt in np.radians([-60, -30, 0, 30, 60]):
        axes.plot(middle + math.cos(tilt) * np.array([-1, 1]), [math.sin(tilt)] * 2, color="#c9d3db", lw=1)
        axes.plot(middle + math.sin(tilt) * np.cos(turn), np.sin(turn), color="#c9d3db", lw=1)
    axes.fill(middle + math.sin(cap) * np.cos(turn), math.sin(cap) * np.sin(turn), fc=VERMILLION, alpha=0.7)
    axes.text(middle, 0, "1 sr", color="white", ha="center", va="center", fontsize=22)
    for x, row, words in ((0, CIRCLE, "around: 2π"), (middle, WHOLE_SPHERE, "all over: 4π")):
        counted = outcome[row].estimate
        axes.text(
            x, -1.4, f"{words}\n{number_text(counted)} {counted.unit}", color=INK, ha="center", va="top"
        )
    bare_panel(axes, (-1.4, middle + 1.2), (-2.1, 1.3))


def draw_steradians(outcomes: list[Outcome], path: Path, note: str) -> None:
    """The shapes as they are seen, on a map of the directions that keeps areas, each with the counted solid angle."""
    from transport.viz.style import BLUE, GREEN, INK, MUTED, VERMILLION, figure

    outcome, shapes = outcomes[0], steradians()
    with figure(
        (5.2 * len(shapes), 7.4),
        "One steradian is the same share of all directions, whatever its shape",
        note,
        path,
    ) as page:
        for axes, (name, axis), colour in zip(
            page.subplots(1, len(shapes)), STERADIANS.items(), (BLUE, VERMILLION, GREEN), strict=True
        ):
            turn = np.linspace(0, 2 * math.pi, 200)
            axes.fill(math.sqrt(2) * np.cos(turn), math.sqrt(2) * np.sin(turn), fc="#f2f2f2", ec=MUTED, lw=2)
            outline = _outline(shapes[name]) @ _frame(np.array(axis, dtype=float))
            axes.fill(*_equal_area(outline).T, fc=colour, ec=INK, lw=2.5, alpha=0.8)
            row = outcome[name].estimate
            axes.set_title(f"{name}\n({row.value:.4f} ± {row.error:.4f}) sr", color=colour)
            axes.set(aspect="equal", xlim=(-1.5, 1.5), ylim=(-1.5, 1.5))
            axes.set_axis_off()
        page.text(
            0.5,
            0.075,
            "each on the hemisphere, drawn so that equal solid angles have equal areas",
            ha="center",
            color=MUTED,
        )


def _frame(axis: np.ndarray) -> np.ndarray:
    """Columns: two directions across the axis, and the axis."""
    first = np.array([0.0, 1.0, 0.0])
    return np.stack([first, np.cross(axis, first), axis], axis=1)


def _equal_area(places: np.ndarray) -> np.ndarray:
    """Lambert's azimuthal map about the third axis; the hemisphere becomes a disk of the radius √2."""
    ways = places / np.linalg.norm(places, axis=1)[:, None]
    return ways[:, :2] * np.sqrt(2 / (1 + ways[:, 2:]))


def draw_footprints(outcomes: list[Outcome], path: Path, note: str) -> None:
    """A cone on planes that are more and more tilted, and the area that it lights."""
    from transport.viz.style import BLUE, INK, MUTED, ORANGE, figure

    spread, tilts = 0.12, [o.given["tilt"] for o in outcomes]  # of the cone as it is drawn
    with figure((16, 7.2), "The footprint of a cone grows as 1/cosθ", note, path) as page:
        left, right = page.subplots(1, 2, gridspec_kw={"width_ratios": (1.5, 1)})
        for k, tilt in enumerate(tilts):
            x = 0.85 * k
            ends = [
                math.cos(tilt)
                / math.cos(tilt + side * spread)
                * np.array([math.sin(side * spread), -math.cos(side * spread)])
                for side in (-1, 1)
            ]
            left.fill(
                [x, x + ends[0][0], x + ends[1][0]],
                [0, ends[0][1], ends[1][1]],
                color=ORANGE,
                alpha=0.35,
                lw=0,
            )
            along = np.array([math.cos(tilt), -math.sin(tilt)])
            left.plot(*(np.array([[x, -1]]) + 0.5 * np.outer([-1, 1], along)).T, color=MUTED, lw=2.5)
            left.plot(
                x + np.array([e[0] for e in ends]),
                [e[1] for e in ends],
                color=BLUE,
                lw=8,
                solid_capstyle="butt",
            )
            left.plot(x, 0, "o", color=INK, ms=9)
            left.text(x, 0.12, f"{math.degrees(tilt):.3g}°", ha="center")
        left.set(aspect="equal", xlim=(-0.55, 0.85 * len(tilts) - 0.35), ylim=(-1.65, 0.3))
        left.set_axis_off()
        fine = np.radians(np.linspace(0, 78, 100))
        grown = [area_of(footprint(t)) / area_of(footprint(0.0)) for t in fine]
        right.plot(np.degrees(fine), grown, color=BLUE, lw=3, label="exact, half angle 2°")
        right.plot(np.degrees(fine), 1 / np.cos(fine), ":", color=INK, lw=2.5, label="1/cosθ")
        right.plot(np.degrees(fine), np.cos(fine), "--", color=MUTED, lw=2.5, label="if it shrank with cosθ")
        rows = [o[GROWTH].estimate for o in outcomes]
        right.errorbar(
            np.degrees(tilts), [r.value for r in rows], [r.error for r in rows], fmt="o", color=BLUE, ms=13
        )
        right.set(
            xlabel="θ of the plane's normal to the cone  [deg]",
            ylabel="footprint / face on",
            xlim=(0, 80),
            ylim=(0, 5.2),
        )
        right.legend(loc="upper left")


draw = figures(
    shapes=(draw_shapes, where(subject=(*SHAPES, "dodecahedron"))),
    caps=(draw_caps, where(subject=("isotropic", "cosine law", "dome"))),
    isotropic=(draw_law, where(subject="isotropic")),
    cosine_law=(draw_law, where(subject="cosine law")),
    radiance=(draw_radiance, where(subject="cosine law")),
    hemisphere=(draw_hemisphere, in_space(where(subject="isotropic"))),
    arcs=(draw_arcs, where(subject="arc and area")),
    steradian=(draw_steradians, where(subject="one steradian")),
    footprint=(draw_footprints, where(subject="footprint")),
)


if __name__ == "__main__":
    main(__file__)
