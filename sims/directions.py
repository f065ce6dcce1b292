"""Directions: they are counted, and the shares are solid angles.

Derivation.  A direction is a point of the unit sphere.  Between the polar angles θ and θ + dθ and the azimuths φ and
φ + dφ lies dω = sinθ dθ dφ (Hanrahan 2001, Stanford CS 348B, lecture 4, "Differential Solid Angles"), so that

    ∫ dω = 2π over a hemisphere, 4π over the sphere;    ∫ cosθ dω = π over a hemisphere.

An isotropic source sends the share dω/4π of its particles into dω, a diffuse one (the cosine law) cosθ dω/π.  So the
share of isotropic directions that meet a shape, times 4π, is the solid angle that it fills: an area that does not lie
on the sphere counts by its projection.  A disk of radius R seen from the distance d on its axis fills
2π (1 - d/√(R² + d²)), a square of side a 4 atan(a²/(2d √(4d² + 2a²))), a triangle what Van Oosterom and Strackee
(1983, eq. 8) say, an octant π/2, a face of a dodecahedron 4π/12 = 1.0472 sr: nearly a steradian, not one.

Scene.  A point within a sphere whose inside is binned in θ and φ;  a tilted diffuse disk;  a dome of uniform radiance
over a disk and a ball, for the integrals as a receiver makes them;  a point and a shape that its directions are aimed
at (`tp.solid_angle`);  a point within a dodecahedron of 36 triangles.

Chi-square.  With N directions and K bins of the probabilities p, X² = Σ (counts - N p)²/(N p) has the expectation
K - 1, exactly and for any N (Pearson 1900).  Each batch gives one X²; their mean over K - 1 is an estimate of 1.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

import transport as tp
from transport.analysis.solid_angle import solid_angle_from_run, solid_angle_scene
from transport.sims import (
    constant,
    curves_figure,
    figures,
    main,
    of_scene,
    one_of,
    sentence,
    sharp,
    where,
)
from transport.theory import solid_angles
from transport.verification.experiment import Outcome

law = (
    "dω = sinθ dθ dφ, ∫dω = 4π, ∫cosθ dω = π; Ω = 4π times the share of directions that meet a shape"
    " (Hanrahan 2001, Stanford CS 348B, lecture 4; Van Oosterom, Strackee 1983)"
)
question = "Do directions follow sinθ dθ dφ and cosθ sinθ dθ dφ, and what solid angles do shapes fill?"
particles = 4_000_000
run = {"sampling": "random"}  # χ² is of independent directions: those of nets are more even than chance

CAPS = (30, 60, 90, 120, 180)  # degrees
POLAR, AZIMUTHS = 24, 40  # bins
TILTED = (1.0, 2.0, -3.0)  # normal of the diffuse disk
BALL = 0.3  # radius of the ball and of the disk in the dome, whose own is 1
SHAPES = {  # seen from the origin; lengths in `size`
    "disk": tp.Disk(center=(0, 0, 1), normal=(0, 0, -1), radius=1.0),
    "square": tp.Rectangle(center=(0, 0, 1), normal=(0, 0, -1), width=1.0, height=1.0),
    "triangle": tp.Triangle(vertices=((1, 0.2, 1.5), (-0.7, 1.1, 2.0), (0.3, -1.3, 0.8))),
    "octant": tp.Triangle(vertices=((1, 0, 0), (0, 1, 0), (0, 0, 1))),
    "sliver": tp.Triangle(vertices=((1, 0, 1), (1, 1e-4, 1), (0, 1, 1))),
}
SUBJECTS = ("isotropic", "cosine law", "dome", *SHAPES, "dodecahedron")
FACE, FACES = "a dodecahedron's face", "its twelve faces"
SLANT, UPWARD = (
    math.radians(36),
    math.radians(35),
)  # from the viewer to a drawn shape, and its way on the page
SMALL = 1e-3  # sr, below which a solid angle is written in µsr
CHI_SQUARE = "χ²/(K − 1)"
ONTO_BALL, ONTO_DISK, ONTO_BACK = "∫dω, onto a ball", "∫cosθ dω, onto a disk", "∫cosθ dω, onto its back"


def cases() -> list[dict[str, object]]:
    return [{"subject": subject} for subject in SUBJECTS]


def scene(subject: str = "isotropic", power: float = 1.0, size: float = 1.0) -> tp.Scene:
    """What directions are counted of.  power [W] of the source;  size: what all lengths are multiplied by [m]."""
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
    return solid_angle_scene(_scaled(SHAPES[subject], size), (0, 0, 0), power)


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    names = list(result)
    if names == ["sky"]:
        return _law_rows(result, sky_shares(result), isotropic_probabilities(), 4 * math.pi, _cap)
    if names == ["leaving"]:
        return _law_rows(result, leaving_shares(result), cosine_probabilities(), math.pi, _projected)
    if names == ["ball", "disk"]:
        return _dome_rows(result)
    return _dodecahedron_rows(result) if len(names) > 1 else {"solid angle": solid_angle_from_run(result)}


@of_scene(scene)
def exact(subject: str) -> dict[str, float]:
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


def _outline(subject: str) -> np.ndarray:
    """Points on the rim of a shape, or of the first face of the dodecahedron, closed (n, 3)."""
    if subject == "dodecahedron":
        corners = solid_angles.dodecahedron_faces(1.0)[0]
    else:
        match shape := SHAPES[subject]:
            case tp.Disk():
                turn = np.linspace(0, 2 * math.pi, 181)
                rim = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=-1)
                return shape.radius * rim + np.array(shape.center)
            case tp.Rectangle():
                half = np.array([(1, 1, 0), (-1, 1, 0), (-1, -1, 0), (1, -1, 0)]) * (
                    shape.width,
                    shape.height,
                    0,
                )
                corners = half / 2 + np.array(shape.center)
            case _:
                corners = np.array(shape.vertices)
    steps = np.linspace(0, 1, 40, endpoint=False)[:, None]
    sides = [a + steps * (b - a) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)]
    return np.concatenate([*sides, sides[0][:1]])


def _draw_shape(axes, outcome: Outcome) -> None:
    """The unit sphere from outside, the shape, its shadow, and rays from the middle of the sphere to the shape's rim."""
    from matplotlib.colors import to_rgb

    from transport.viz.style import BLUE, INK, MUTED, ORANGE, VERMILLION
    from transport.viz.wording import number_text

    subject, row = outcome.given["subject"], outcome.rows[0]
    rim = _outline(subject)
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
    if subject == "dodecahedron":
        for face in solid_angles.dodecahedron_faces(1.0):
            if (face.mean(axis=0) @ np.cross(*screen.T)) > 0:
                axes.plot(*(face[[0, 1, 2, 3, 4, 0]] @ screen).T, color=BLUE, lw=1.6, zorder=2)
    axes.fill(*(rim @ screen).T, fc=(*to_rgb(BLUE), 0.16), lw=0, zorder=2.5)
    axes.plot(*(rim @ screen).T, color=BLUE, lw=4, zorder=4)
    corners = rim[:-1][:: max(1, (len(rim) - 1) // (4 if subject == "disk" else len(rim) // 40))]
    for corner in corners:
        far = corner * max(1.0, 1 / np.linalg.norm(corner))
        axes.plot(*np.stack([0 * far[:2], far @ screen]).T, color=INK, lw=1.4, zorder=5)
    axes.plot(0, 0, "o", color=INK, ms=11, zorder=6)
    scale, unit = (1.0, "sr") if row.exact > SMALL else (1e6, "µsr")
    name = "dodecahedron's face" if subject == "dodecahedron" else subject
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


def draw_radiance(outcomes: list[Outcome], **out: object) -> None:
    """The directions of the cosine law over cosθ dω: the same radiance up to the horizon."""
    from transport.viz.maps import plot_map

    seen = outcomes[0].result["leaving"]
    level = outcomes[0].result.ledger["emitted"].value / (math.pi * seen.area)
    title = "The cosine law, divided by cosθ dω: the same radiance in all directions"
    words = {"quantity": "radiance_out", "label": "radiance L", "title": title}
    plot_map(seen, exact=lambda theta, phi: level + 0 * theta, cut=True, **words, **out)


draw = figures(
    shapes=(draw_shapes, where(subject=(*SHAPES, "dodecahedron"))),
    caps=(draw_caps, where(subject=("isotropic", "cosine law", "dome"))),
    isotropic=(draw_law, where(subject="isotropic")),
    cosine_law=(draw_law, where(subject="cosine law")),
    radiance=(draw_radiance, where(subject="cosine law")),
)


if __name__ == "__main__":
    main(__file__)
