"""Throughput: rays are counted alike before and behind mirrors, a ball of glass and a lens; a sensor reads L times them.

Derivation.  T = ∬ cosθ dω dA counts the rays of a beam and "is unchanged under the laws of geometric optics (straight
lines, reflection, refraction, mirages)"; a sensor that sees the radiance L within its throughput responds R = L T
(Hanrahan 2001, Stanford CS 348B, lecture 4, "Throughput" and "2nd law").  For dA cosθ dω = dx dy dp_x dp_y with direction
cosines p is a volume in phase space, which every such law keeps (Liouville; Straubel 1902).

Beams.  Between an aperture 1, an optic and an aperture 2 lies one beam, and it has two measures: in the coordinates of
aperture 1, ∬ cosθ₁ dω₁ dA₁ over the rays that reach 2, and in those of aperture 2 over the rays that come from 1.  A
diffuse source at 1 draws rays uniformly in the first, one at 2 in the second; what each brings to the other, over L, is
T.  Were the optic's map not one that conserves throughput, the two would differ: a lens that maps tangents is seen to
(tests/experiments/test_throughput.py).  And what falls on the optic leaves it, history by history.

Exact values.  Aperture 2 is large enough for all that comes from 1 (its radius is taken from traced rays; the flat
mirror's alone is not, and there the image of 1 serves), so that T is that between aperture 1 and the optic's rim, two
coaxial disks (Howell, C-41), for a cap or a bowl as for a lens.  Behind the glass ball each ray counts with what Fresnel
lets through, the same both ways; `events=2` leaves out what was reflected inside.

Sensor.  A plate with a hole before a diffuse wall; behind it sensors at several distances.  The wall fills all that they
see through the hole: R = L T of hole and sensor, whatever the wall's distance.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

import transport as tp
from transport.sims import (
    constant,
    figures,
    main,
    of_scene,
    one_of,
    provenance,
    require,
    sharp,
    where,
)
from transport.theory import etendue, lenses, optical_paths
from transport.theory.optical_paths import Rays, reach_at
from transport.verification.experiment import Outcome

law = "T in = T out, T = ∬ cosθ dω dA; R = L T (Straubel 1902; Hanrahan 2001, Stanford CS 348B, lecture 4)"
question = "Do mirrors and lenses keep the number of rays, and does a sensor read radiance times throughput?"
particles = 4_000_000
intended = {
    "aim": "only rays through the aperture at which the lamp is aimed are wanted",
    "unknown error": "each aperture has a counter for every way, and by some of them no light comes",
    "enclosed detector": "the back of the mirror is dark",
    "bins": "cells at the edge of the beam are met by few rays; the rows are of all cells",
}

SHOWS = ("flat mirror", "spherical mirror", "paraboloid", "glass ball", "lens", "sensor")
FOCAL = 0.1  # m, of the lens and of both curved mirrors
NEAR, FAR = 1.5 * FOCAL, 3 * FOCAL  # of aperture 1 and of its image
RIM = 0.5 * FOCAL  # m, radius of the lens
CAP, BOWL = 30 * tp.deg, 75 * tp.deg  # of the mirrors' rims, seen from the center and from the focus
BALL, WINDOW = 0.06, 0.025  # m, radii of the ball and of the stop before it
ROOM = 1.02  # of aperture 2 over what the traced rays need
HOLE, SENSOR = 0.01, 0.02  # m, radii
BEHIND = (0.1, 0.2, 0.5)  # m, of the sensors
T_1, T_2, KEPT = "T, rays from 1 to 2", "T, rays from 2 to 1", "flux on the optic − flux off it"
READ = "R/T, {} m behind the hole"
SLIT, BINS = 4e-3, 26  # m, height of the picture's meters; bins a side
SECTOR = math.radians(4)  # half of it: rays near the plane of the axis
SHOWN, WIDE = 3 * FOCAL, 1.5  # m, of an axis in a sketch; width of a sketch over its height
MIDDLE = ", middle"  # ending of the names of the detectors that count round p = 0
PLANES = ("at aperture 1", "before the lens", "behind the lens", "at aperture 2")


class Beam(NamedTuple):
    """Two apertures that face an optic: where source 1 and source 2 aim, the surfaces, which of them to go by, and T."""

    one: tp.Disk
    two: tp.Disk
    aims: tuple[tp.Shape, tp.Shape]
    surfaces: tuple[tp.Surface, ...]
    throughput: float
    events: int | None = None


def cases() -> list[dict[str, object]]:
    beams = [{"show": show} for show in SHOWS[:-1]]
    return beams + [{"show": "sensor", "distance": distance} for distance in (0.5, 5.0, 50.0)]


def scene(
    show: str = "lens", size: float = 0.01, radiance: float = 100.0, index: float = 1.5, distance: float = 0.5
) -> tp.Scene:
    """A beam between two apertures by way of an optic, or sensors behind a hole before a wall.

    size: radius of aperture 1 [m];  index: of the ball's glass;  distance: of the wall from the hole [m].
    """
    one_of("throughput", show=(show, SHOWS))
    shine = tp.Lambertian(radiance=radiance)
    if show == "sensor":
        return _sensors(distance, shine)
    beam = beam_of(show, size, index)
    pairs = ((beam.one, beam.aims[0]), (beam.two, beam.aims[1]))
    counters = [
        tp.Detector(beam.one, "one", via=("two", "optic"), events=beam.events),
        tp.Detector(beam.two, "two", via=("one", "optic"), events=beam.events),
        tp.Detector(beam.two, "two again", via=("two", "one", "optic"), events=beam.events),
        *(tp.Detector("optic", f"optic {side}", side=side) for side in ("front", "back")),
    ]
    return tp.Scene(
        sources=[tp.Source(disk, shine, aim=aim) for disk, aim in pairs],
        surfaces=beam.surfaces,
        detectors=counters + (_portraits(beam) if show == "lens" else []),
    )


def beam_of(show: str, size: float, index: float) -> Beam:
    """The beam of that name with an aperture 1 of that radius [m]."""
    require("throughput", size=(size, 0 < size < 0.5 * FOCAL, f"in (0, {0.5 * FOCAL:g}) m"))
    made = dict(zip(SHOWS, (_flat, _cap, _bowl, partial(_ball, index=index), _lens), strict=False))
    return made[show](size)


def _flat(size: float) -> Beam:
    """Folded by 45 degrees: seen in the mirror, aperture 2 lies FAR beyond it on the axis, and is the smaller one."""
    one = _facing(size, -NEAR, 1)
    two = tp.Disk(center=(FAR, 0, 0), normal=(-1, 0, 0), radius=0.7 * size)
    mirror = tp.Rectangle(normal=(1, 0, -1), up=(0, 1, 0), width=4 * size, height=4 * size)
    fold = [tp.Disk(normal=disk.normal, radius=size) for disk in (one, two)]  # where the beam is no wider
    rays = etendue.disks_throughput(size, two.radius, NEAR + FAR)
    return Beam(one, two, tuple(fold), (tp.Surface(mirror, tp.Mirror(), name="optic"),), float(rays))


def _cap(size: float) -> Beam:
    """A concave mirror about the origin, its focal length half its radius; both apertures on the axis before it."""
    radius = 2 * FOCAL
    rim, height = radius * math.sin(CAP), radius * math.cos(CAP)
    cap = tp.Sphere(radius=radius, mu_min=math.cos(CAP))
    step = partial(optical_paths.reflect_in_sphere, center=0.0, radius=radius)
    return _on_axis(
        size, radius - NEAR, radius - FAR, (rim, height), tp.Surface(cap, tp.Mirror(), name="optic"), step
    )


def _bowl(size: float) -> Beam:
    """Aperture 1 in the focus; what leaves is nearly parallel, and aperture 2 lies across it."""
    rim = 2 * FOCAL * math.tan(BOWL / 2)
    height = -FOCAL * math.cos(BOWL) / math.cos(BOWL / 2) ** 2
    bowl = tp.Paraboloid(center=(0, 0, -FOCAL), focal_length=FOCAL, radius=rim)
    step = partial(optical_paths.reflect_in_paraboloid, vertex=-FOCAL, focal_length=FOCAL)
    return _on_axis(size, 0.0, 10 * FAR, (rim, height), tp.Surface(bowl, tp.Mirror(), name="optic"), step)


def _lens(size: float) -> Beam:
    step = partial(optical_paths.bend, height=0.0, focal_length=FOCAL)
    lens = tp.Surface(tp.Disk(radius=RIM), tp.ThinLens(FOCAL), name="optic")
    return _on_axis(size, -NEAR, FAR, (RIM, 0.0), lens, step)


def _on_axis(
    size: float,
    z_1: float,
    z_2: float,
    rim: tuple[float, float],
    optic: tp.Surface,
    step: Callable[[Rays], Rays],
) -> Beam:
    """Apertures at heights z_1 and z_2 on the axis of an optic whose rim is a circle of (radius, height)."""
    radius, height = rim
    rays = step(optical_paths.between_disks(size, z_1, radius, height))
    one, two = _facing(size, z_1, height - z_1), _facing(ROOM * reach_at(rays, z_2), z_2, height - z_2)
    aim = tp.Disk(center=(0, 0, height), radius=radius)
    rays = etendue.disks_throughput(size, radius, abs(height - z_1))
    return Beam(one, two, (aim, aim), (optic,), float(rays))


def _ball(size: float, index: float) -> Beam:
    """A ball of glass about the origin behind a black stop."""
    stop, z_1, z_2 = -1.1 * BALL, -2.5 * BALL, 2.5 * BALL
    faces, height = lenses.ball(-z_1, BALL), stop - z_1
    rays = optical_paths.between_disks(size, 0.0, WINDOW, height)
    passed = lenses.trace(rays, faces, index)
    beyond, wide = (ROOM * reach_at(passed, z - z_1) for z in (-stop, z_2))
    one, two = _facing(size, z_1, 1), _facing(wide, z_2, -1)
    surfaces = (
        tp.Surface(tp.Sphere(radius=BALL), tp.Dielectric(index), name="optic"),
        tp.Surface(
            tp.Disk(center=(0, 0, stop), inner_radius=WINDOW, radius=2 * BALL), tp.Black(), name="stop"
        ),
    )
    aims = tp.Disk(center=(0, 0, stop), radius=WINDOW), tp.Disk(center=(0, 0, -stop), radius=beyond)
    seen = lenses.projected_solid_angle(faces, index, size, WINDOW, height)
    return Beam(one, two, aims, surfaces, one.area * seen, 2)


def _facing(radius: float, height: float, way: float) -> tp.Disk:
    """A disk about the axis that looks up or down as the sign of `way` says."""
    return tp.Disk(center=(0, 0, height), normal=(0, 0, math.copysign(1, way)), radius=radius)


def _sensors(distance: float, shine: tp.Lambertian) -> tp.Scene:
    """The light goes up: wall, plate, sensors that look down.  The wall fills what the nearest sees through the hole."""
    steepest = (HOLE + SENSOR) / min(BEHIND)
    wall = tp.Disk(center=(0, 0, -distance), radius=ROOM * (HOLE + steepest * distance))
    hole = tp.Disk(radius=HOLE)
    plate = tp.Rectangle(width=1.0, height=1.0, hole=hole)
    sensors = [tp.Detector(_facing(SENSOR, z, -1), f"sensor {k}") for k, z in enumerate(BEHIND)]
    return tp.Scene(tp.Source(wall, shine, aim=hole), tp.Surface(plate, tp.Black(), name="plate"), sensors)


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    shine = constant(result, result.scene.sources[0].emission.radiance, "W m^-2 sr^-1")
    if "one" not in result:
        rays = [constant(result, sensor_throughput(z), "m^2 sr") for z in BEHIND]
        fluxes = [result[f"sensor {k}"].flux_in for k in range(len(BEHIND))]
        return {READ.format(z): flux / t for z, flux, t in zip(BEHIND, fluxes, rays, strict=True)}
    front, back = result["optic front"], result["optic back"]
    on, off = front.flux_in + back.flux_in, front.flux_out + back.flux_out
    at_two = result["two"].flux_in - result["two again"].flux_in  # but what source 2 sent back by aperture 1
    return {T_1: at_two / shine, T_2: result["one"].flux_in / shine, KEPT: sharp(on - off, of=on)}


def sensor_throughput(distance: float) -> float:
    """Of the hole and a sensor so far behind it [m^2 sr]."""
    return float(etendue.disks_throughput(HOLE, SENSOR, distance))


@of_scene(scene)
def exact(show: str, size: float, radiance: float, index: float) -> dict[str, float]:
    if show == "sensor":
        return {READ.format(z): radiance for z in BEHIND}
    rays = beam_of(show, size, index).throughput
    return {T_1: rays, T_2: rays, KEPT: 0.0}


def _portraits(beam: Beam) -> list[tp.Detector]:
    """Meters of what comes from aperture 1 through narrow slits at PLANES, by place and direction along x."""
    gap = 1e-3  # m, between the slits and what they stand beside
    heights = beam.one.center[2] + gap, -gap, gap, beam.two.center[2] - gap
    reaches = 1.4 * beam.one.radius, 1.15 * RIM, 1.15 * RIM, 1.1 * beam.two.radius
    steepest = (0.45, 0.45, 0.38, 0.38)  # direction cosines
    slits = []
    for name, height, reach, steep in zip(PLANES, heights, reaches, steepest, strict=True):
        slit = tp.Rectangle(center=(0, 0, height), normal=(0, 0, -1), width=2 * reach, height=SLIT)
        theta, phi = np.arcsin(np.linspace(0, steep, BINS // 2 + 1)), (-SECTOR, SECTOR)
        bins = tp.Directions(theta=theta, phi=(*phi, *(math.pi + angle for angle in phi)))
        how = {"positions": tp.Positions(u=BINS), "via": "one"}
        slits.append(tp.Detector(slit, name, directions=bins, **how))
        # Round p = 0 few rays are in the sectors; all azimuths fly as flat there.
        slits.append(tp.Detector(slit, f"{name}{MIDDLE}", directions=tp.Directions(theta=theta[:2]), **how))
    return slits


def verdict(outcomes: list[Outcome]) -> str:
    """How far the two measures of a beam are apart, and what the sensors read."""
    sentences = []
    if beams := where(show=SHOWS[:-1])(outcomes):
        scores = [abs((o[T_1].estimate / o[T_2].estimate).z(1.0)) for o in beams]
        names, off = ", ".join(o.given["show"] for o in beams), f"{max(scores):.1f} standard errors apart"
        sentences.append(f"By way of {names} rays count alike from both ends, at most {off}.")
    if read := [row.estimate.value / row.exact for o in where(show="sensor")(outcomes) for row in o.rows]:
        sentences.append(
            f"R/T is {min(read):.4f} to {max(read):.4f} L for every distance of wall and sensor."
        )
    return " ".join(sentences)


def draw_portraits(outcomes: list[Outcome], path: Path, note: str) -> None:
    """The lens' beam in phase space at four places: its shape changes, its area and the radiance within do not."""
    from transport.viz.style import PURPLE, SEQUENTIAL, SKY, figure, outlined

    title, cm = "A beam through a lens: another shape, the same area, the same radiance", 100.0
    with figure((5.0 * len(PLANES) + 1.8, 7.2), title, provenance(outcomes[:1]), path) as page:
        panels = page.subplots(1, len(PLANES))
        for axes, plane in zip(panels, PLANES, strict=True):
            x, p, shares, outlines = _portrait(outcomes[0], plane)
            mesh = axes.pcolormesh(cm * x, p, shares.T, vmin=0, vmax=1.25, cmap=SEQUENTIAL, rasterized=True)
            for (words, outline, area), colour, line in zip(
                outlines, (SKY, PURPLE), ("-", "--"), strict=False
            ):
                closed = np.concatenate([outline, outline[:1]])
                axes.plot(cm * closed[:, 0], closed[:, 1], line, color=colour, lw=2.4)
                place = {"transform": axes.transAxes, "ha": "center", "path_effects": outlined()}
                height, place["va"] = (0.03, "bottom") if line == "-" else (0.97, "top")
                axes.text(0.5, height, f"{words}{1e3 * area:.3f} mm", color=colour, **place)
            axes.set(
                title=plane, xlabel="place x  [cm]", xlim=cm * x[[0, -1]], ylim=p[[0, -1]], facecolor="black"
            )
            axes.grid(False)
        panels[0].set_ylabel("direction cosine p")
        bar = page.colorbar(mesh, ax=panels, extend="max", aspect=30)
        bar.set_label("radiance / that of the source")


def _portrait(outcome: Outcome, plane: str) -> tuple[np.ndarray, np.ndarray, np.ndarray, list]:
    """Edges of x and p_x, radiance over that of the source in these bins, and outlines of traced rays with their areas."""
    reading, source = outcome.result[plane], outcome.result.scene.sources[0]
    shares = reading.radiance.value / source.emission.radiance
    cosines, places = np.sin(reading.radiance.coords["theta"]), reading.radiance.coords["u"]
    middle = outcome.result[f"{plane}{MIDDLE}"].radiance.value[:, :1] / source.emission.radiance
    # The slit looks down: e_u is -x, and light flies against the direction that it comes from.
    of_x_and_p = np.concatenate([shares[:, :0:-1, 2], middle, shares[:, 1:, 0]], axis=1)[::-1]
    height, edges = reading.detector.shape.center[2], np.concatenate([-cosines[:0:-1], cosines[1:]])
    rays = etendue.meridional_outline(source.shape.radius, source.shape.center[2], RIM, 0.0)
    bends = {"area ": None}
    if height > 0:
        bends = {"area ": optical_paths.bend, "if the lens mapped tangents:\n": optical_paths.bend_tangents}
    outlines = []
    for words, bend in bends.items():
        there = optical_paths.to_plane(bend(rays, 0.0, FOCAL) if bend else rays, height)
        outline = np.stack([there.points[:, 0], there.directions[:, 0]], axis=-1)
        outlines.append((words, outline, etendue.outlined_area(*outline.T)))
    return -places[::-1], edges, of_x_and_p, outlines


def draw_laws(outcomes: list[Outcome], path: Path, note: str) -> None:
    """Rays by way of each optic with the throughput in both directions, and what sensors read of a wall."""
    from transport.viz.style import figure

    beams, sensors = where(show=SHOWS[:-1])(outcomes), where(show="sensor")(outcomes)
    panels = len(beams) + bool(sensors)
    columns = min(3, panels)
    rows = -(-panels // columns)
    title = (
        "T from 1 to 2 is T from 2 to 1  [mm² sr]" if beams else "A sensor reads L T, however far the wall"
    )
    with figure((7.0 * columns + (2.5 if not beams else 0), 6.8 * rows + 1.0), title, note, path) as page:
        grid = page.subplots(rows, columns, squeeze=False).ravel()
        for axes, outcome in zip(grid, beams, strict=False):
            _draw_beam(axes, outcome)
        if sensors:
            _draw_sensors(grid[len(beams)], sensors)
        for axes in grid[panels:]:
            axes.remove()


def _draw_beam(axes, outcome: Outcome) -> None:
    """Section of the beam along the axis, from left to right: apertures, optic, rays; and both measures of its throughput."""
    from transport.viz.exhibits import bare_panel
    from transport.viz.style import BLUE, INK, ORANGE, SKY, VERMILLION
    from transport.viz.wording import number_text

    show, size, index = (outcome.given[name] for name in ("show", "size", "index"))
    beam = beam_of(show, size, index)
    lines, optic = _section(show, beam, index)
    for line in lines:
        axes.plot(*line.T, color=ORANGE, lw=1.6, zorder=2)
    fill = {"fc": SKY, "alpha": 0.5} if show == "glass ball" else {"fc": "none"}
    axes.fill(*optic.T, ec=INK, lw=4, closed=show == "glass ball", zorder=3, **fill)
    if show == "glass ball":
        for side in (-1, 1):
            axes.plot([-1.1 * BALL] * 2, [side * WINDOW, side * BALL], color=INK, lw=5, zorder=3)  # the stop
    ends = [*lines, optic]
    for name, disk, colour in (("1", beam.one, BLUE), ("2", beam.two, VERMILLION)):
        normal, middle = np.array(disk.normal)[[2, 0]], np.array(disk.center)[[2, 0]]
        if middle[0] > SHOWN:
            name, middle[0] = f"{name}, at {middle[0]:.2g} m", SHOWN
        side = np.array([-normal[1], normal[0]])
        rim = middle + np.outer((-1, 1), disk.radius * side)
        ends.append(rim)
        axes.plot(*rim.T, color=colour, lw=7, solid_capstyle="butt", zorder=4)
        place = rim[np.argmax(rim[:, 1])]
        axes.annotate(
            name,
            place,
            (0, 6),
            textcoords="offset points",
            color=colour,
            fontsize=24,
            fontweight="bold",
            ha="center",
        )
    words = [
        show,
        f"1 → 2:  {number_text(outcome[T_1].estimate, 1e6)}",
        f"2 → 1:  {number_text(outcome[T_2].estimate, 1e6)}",
        f"exact:   {1e6 * outcome[T_1].exact:.5g}",
    ]
    axes.set_title("\n".join(words), loc="left", linespacing=1.3)
    ends = np.concatenate(ends)
    # Panels of one form, so that all have one size.
    low, high = ends.min(axis=0), ends.max(axis=0)
    half = 0.58 * max(high[0] - low[0], WIDE * (high[1] - low[1])) * np.array([1, 1 / WIDE])
    bare_panel(axes, *zip((low + high) / 2 - half, (low + high) / 2 + half, strict=True))


def _section(show: str, beam: Beam, index: float) -> tuple[list[np.ndarray], np.ndarray]:
    """Rays in the plane of the axis (z, x), and the optic's outline there [m]."""
    z_1, z_2 = beam.one.center[2], beam.two.center[2]
    across, turn = np.linspace(-0.95, 0.95, 5), np.linspace(-1, 1, 101)
    if show == "flat mirror":
        starts = [np.array([z_1, x]) for x in (-0.9 * beam.one.radius, 0, 0.9 * beam.one.radius)]
        ends = [np.array([x, FAR]) for x in beam.two.radius * across]  # aperture 2 lies aside of the axis
        images = [(end, end[::-1]) for end in ends]
        lines = []
        for start in starts:
            for end, image in images:
                share = (start[1] - start[0]) / (start[1] - start[0] + image[0] - image[1])
                lines.append(np.stack([start, start + share * (image - start), end]))
        return lines, math.sqrt(2) * beam.one.radius * np.array([[-1, -1], [1, 1]])
    if show == "glass ball":
        rim, height = WINDOW, -1.1 * BALL
        outline = BALL * np.stack([np.cos(math.pi * turn), np.sin(math.pi * turn)], axis=-1)
        steps = [
            partial(optical_paths.refract, center=0.0, radius=BALL, index=index),
            partial(optical_paths.refract, center=0.0, radius=BALL, index=1 / index, far=True),
        ]
    elif show == "spherical mirror":
        rim, height = 2 * FOCAL * math.sin(CAP), 2 * FOCAL * math.cos(CAP)
        outline = 2 * FOCAL * np.stack([np.cos(CAP * turn), np.sin(CAP * turn)], axis=-1)
        steps = [partial(optical_paths.reflect_in_sphere, center=0.0, radius=2 * FOCAL)]
    elif show == "paraboloid":
        rim, height = 2 * FOCAL * math.tan(BOWL / 2), -FOCAL * math.cos(BOWL) / math.cos(BOWL / 2) ** 2
        outline = np.stack([(rim * turn) ** 2 / (4 * FOCAL) - FOCAL, rim * turn], axis=-1)
        steps = [partial(optical_paths.reflect_in_paraboloid, vertex=-FOCAL, focal_length=FOCAL)]
    else:
        rim, height, outline = RIM, 0.0, np.array([[0, -RIM], [0, RIM]])
        steps = [partial(optical_paths.bend, height=0.0, focal_length=FOCAL)]
    lines = []
    for start in (-0.9 * beam.one.radius, 0.0, 0.9 * beam.one.radius):
        rays = optical_paths.from_to(
            np.array([start, 0, z_1]), np.stack([rim * across, 0 * across, height + 0 * across], axis=-1)
        )
        places = [np.broadcast_to([start, 0, z_1], rays.points.shape)]
        for step in steps:
            rays = step(rays)
            places.append(rays.points)
        places.append(optical_paths.to_plane(rays, min(z_2, SHOWN)).points)
        lines += list(np.stack(places, axis=1)[..., [2, 0]])
    return lines, outline


def _draw_sensors(axes, outcomes: list[Outcome]) -> None:
    """R/T of each sensor against the wall's distance, dashed if the wall's light fell with the distance."""
    from transport.viz.curves import Series, plot_curves

    distances, level = [o.given["distance"] for o in outcomes], outcomes[0].given["radiance"]
    series = {}
    for rank, z in enumerate(BEHIND):
        aside = 1.12 ** (rank - 1)  # so that points do not hide one another
        read = [o[READ.format(z)].estimate for o in outcomes]
        exact_level = (lambda d: level + 0 * d) if rank == 0 else None
        places = [distance * aside for distance in distances]
        series[f"{z:g} m behind the hole"] = Series(places, read, exact_level, [level] * len(read))
    plot_curves(
        series, ax=axes, guides={"wrong: as 1/d²": lambda d: level * (min(distances) / d) ** 2}, log_x=True,
        xlabel="distance d of the wall  [m]", ylabel="R / T", legend="center right",
    )  # fmt: skip
    axes.set(ylim=(0, 1.15 * level), title="sensor: R = L T")


draw = figures(portraits=(draw_portraits, where(show="lens")), laws=draw_laws)


if __name__ == "__main__":
    main(__file__)
