"""Fog: the exception to the law that radiance is the same all along a ray.

Derivation.  In vacuum radiance is invariant along a ray; in a medium each length ds takes the share σ ds out of
it, σ the extinction, so that L falls by exp(-τ), τ = ∫ σ ds (Bouguer 1729; Beer 1852).  What is left never
collided.  Where all that collides is absorbed this is all the light; what is scattered comes on top.

"disk".  A Lambertian disk and a meter on its axis, with absorbing fog of the depth τ between.  A ray at the
angle θ has τ/cosθ before it: a bin of directions holds the mean of L exp(-τ/μ), weighted with μ, and the
irradiance is 2π L ∫ μ exp(-τ/μ) dμ.  It is not exp(-τ) times that in clear air, which forgets the slant; of a
disk that fills half the world 2 E3(τ) is left.
"lamp".  The same in fog that only scatters, mostly forward.  What comes straight is that of absorbing fog; the
rest is a glow about the lamp, and the irradiance is higher.
"room".  A ball of fog within a wall that glows.  Fog that absorbs nothing scatters into each ray what it
scatters out of it: radiance is L everywhere; of what comes by a chord 2R μ exp(-2R σ μ) is direct.
"sun".  Its radiance is 2.3e7 W m⁻² sr⁻¹ at its surface and about 1.4e7 seen from the ground (Scratchapixel, on
radiometric quantities), so that the atmosphere has τ = ln(2.3/1.4) = 0.50, if that is at the zenith: inferred,
the source says neither this nor which part of the spectrum is meant.  At the zenith angle z it is exp(-τ/cos z)
in a flat atmosphere; logarithms read on the ground, drawn on to no air, give that above it (Langley 1903).

Scene.  Fog is in a Slab or a Box without a wall, or everywhere: `place`.  Where light is absorbed only,
directions are aimed at the meter.  Bins keep off the disk's rim by the meter's radius (sims/lambert_disk.py).
"""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path

import numpy as np

import transport as tp
from transport.sims import constant, provenance, sharp
from transport.theory import attenuation, emitters
from transport.verification.experiment import Outcome

law = "L = L0 exp(-τ) along a ray, E = 2π L ∫ μ exp(-τ/μ) dμ (Bouguer 1729; Beer 1852; Chandrasekhar 1960)"
question = "Is radiance the same all along a ray in fog, and what of the light that reaches us came straight?"
particles = 1_000_000

RADIANCE = 100.0  # W m^-2 sr^-1
DISK, LAMP = (0.5, 0.2, 5e-4), (0.3, 1.0, 0.1)  # m: radius, distance and radius of the meter
BINS = 6  # within the disk's cone, even in the length of the way
ANGLES = np.radians([0, *range(6, 91, 2)])  # of the disk's picture
LAMP_ANGLES = np.radians([0, 4, *range(6, 31, 2), *range(35, 61, 5), 70, 90])  # wider where its glow fades
LAMP_G = 0.8  # mean cosine of the scattering angle
WALL = np.linspace(0, 1, 5)  # cosines of directions at the room's wall
SURFACE, GROUND = 2.3e7, 1.4e7  # W m^-2 sr^-1, the sun's radiance
ATMOSPHERE = math.log(SURFACE / GROUND)
SUN_ANGLE = math.asin(float(emitters.sphere_radius(emitters.AREA)) / tp.au)
AIR = (1e3, 1e4)  # m: where the atmosphere begins above the meter, and its thickness
READINGS, PLACES = ("disk", "lamp", "room", "sun"), ("slab", "box", "everywhere")
IRRADIANCE, DIRECT = "irradiance", "irradiance, direct"
IN_LAMP, SUN = "radiance of the lamp, direct", "radiance of the sun"


def cases() -> list[dict[str, object]]:
    disks = [(0.0, "slab"), (0.5, "slab"), (1.0, "box"), (2.0, "everywhere")]
    return [
        *({"reading": "disk", "tau": tau, "place": place} for tau, place in disks),
        {"reading": "lamp", "tau": 1.0},
        {"reading": "room", "tau": 2.0},
        {"reading": "sun", "tau": 0.0},
        *({"reading": "sun", "tau": ATMOSPHERE, "zenith_angle": angle * tp.deg} for angle in (0, 60, 75)),
    ]


def scene(
    reading: str = "disk", tau: float = 1.0, place: str = "slab", zenith_angle: float = 0.0
) -> tp.Scene:
    """A "disk" in absorbing fog, a "lamp" in scattering fog, a "room" full of it, or the "sun".

    tau: optical depth straight from source to meter; across the room; of the atmosphere at the zenith. place:
    of the fog before the disk: in a "slab" or a "box" between, or "everywhere".  zenith_angle: of the sun [rad].
    """
    for name, value, known in (("reading", reading, READINGS), ("place", place, PLACES)):
        if value not in known:
            raise tp.SceneError(f"fog: {name} must be one of {', '.join(known)}, got {value!r}")
    if not 0 <= zenith_angle < math.pi / 2 - SUN_ANGLE:
        raise tp.SceneError(f"fog: zenith_angle must be from 0 to below 90°, got {zenith_angle} rad")
    if reading in ("room", "sun"):
        return _room(tau) if reading == "room" else _sun(tau, zenith_angle)
    return _disk(reading, tau, place if reading == "disk" else "slab")


def _disk(reading: str, tau: float, place: str) -> tp.Scene:
    """Source and meter face each other; in a slab or a box the fog fills the middle half of the way."""
    is_lamp, (radius, distance, size) = reading == "lamp", LAMP if reading == "lamp" else DISK
    meter = tp.Disk(center=(0, 0, distance), normal=(0, 0, -1), radius=size)
    middle, depth = (0, 0, distance / 2), distance if place == "everywhere" else distance / 2
    fog = tp.Medium(absorption=tau / depth)
    if is_lamp:
        fog = tp.Medium(scattering=tau / depth, phase=tp.HenyeyGreenstein(LAMP_G))

    def look(name: str, angles: np.ndarray, events: int | None = None) -> tp.Detector:
        return tp.Detector(meter, name, directions=tp.Directions(theta=angles), events=events)

    bins, angles = _edges(reading), LAMP_ANGLES if is_lamp else ANGLES
    views = [look("view", angles)]
    views += [look("direct", bins, 0), look("direct view", angles, 0)] if is_lamp else [look("meter", bins)]
    body = tp.Slab(center=middle, thickness=depth)
    if place == "box":
        body = tp.Box(center=middle, size=(3 * radius, 3 * radius, depth))
    return tp.Scene(
        tp.Source(tp.Disk(radius=radius), tp.Lambertian(radiance=RADIANCE), aim=None if is_lamp else meter),
        [] if place == "everywhere" else tp.Surface(body, tp.Transparent(), name="fog", inside=fog),
        views,
        medium=fog if place == "everywhere" else tp.Vacuum(),
    )


def _edges(reading: str) -> np.ndarray:
    """Edges of bins within the cone of the source, even in 1/cosθ, then the rim and the horizon [rad]."""
    radius, distance, size = LAMP if reading == "lamp" else DISK
    within, beyond = math.hypot(distance, radius - size) / distance, math.atan((radius + size) / distance)
    ways = np.linspace(1, within, (1 if reading == "lamp" else BINS) + 1)
    return np.array([*np.arccos(1 / ways), beyond, math.pi / 2])


def _room(tau: float) -> tp.Scene:
    """Fog that only scatters, within a wall that glows; the wall's meters look at what arrives."""
    ball, bins = tp.Sphere(radius=1.0), tp.Directions(mu=WALL)
    fog = tp.Medium(scattering=tau / (2 * ball.radius), phase=tp.HenyeyGreenstein(LAMP_G))
    return tp.Scene(
        tp.Source("room", tp.Lambertian(radiance=RADIANCE), side="inside"),
        tp.Surface(ball, tp.Black(), name="room", inside=fog),
        [
            tp.Detector("room", "wall", side="inside", directions=bins),
            tp.Detector("room", "direct", side="inside", directions=bins, events=0),
        ],
    )


def _sun(tau: float, zenith_angle: float) -> tp.Scene:
    """The sun far along +x, a square metre that faces it, and above that a slab of air, tilted."""
    up = (math.cos(zenith_angle), 0, math.sin(zenith_angle))
    air = tp.Slab(center=[(AIR[0] + AIR[1] / 2) * x for x in up], normal=up, thickness=AIR[1])
    meter = tp.Rectangle(normal=(1, 0, 0), width=1, height=1)
    ball = tp.Sphere(center=(tp.au, 0, 0), radius=tp.au * math.sin(SUN_ANGLE))
    return tp.Scene(
        tp.Source(ball, tp.Lambertian(radiance=SURFACE), aim=meter),
        tp.Surface(air, tp.Transparent(), name="air", inside=tp.Medium(absorption=tau / AIR[1])),
        tp.Detector(meter, "meter", directions=tp.Directions.cone((1, 0, 0), SUN_ANGLE)),
    )


def measure(result: tp.Result) -> dict[str, tp.Estimate]:
    if "wall" in result:
        wall, direct = result["wall"], result["direct"]
        rows = {_bin("radiance", WALL, i): each for i, each in enumerate(wall.radiance)}
        rows |= {_bin("radiance, direct", WALL, i): each for i, each in enumerate(direct.radiance)}
        return rows | {IRRADIANCE: sharp(wall.irradiance, of=wall.irradiance), DIRECT: direct.irradiance}
    if "direct" in result:
        return {DIRECT: result["direct"].irradiance, IN_LAMP: result["direct"].radiance[0]}
    meter, seen, cosines = result["meter"], result["meter"].radiance, np.cos(_edges("disk"))
    if "air" in [surface.name for surface in result.scene.surfaces]:
        return {SUN: seen[0]}
    rows = {_bin("radiance", cosines, i): seen[i] for i in range(BINS)}
    return rows | {IRRADIANCE: meter.irradiance, "radiance beside the disk": seen[BINS + 1]}


def exact(
    reading: str = "disk", tau: float = 1.0, place: str = "slab", zenith_angle: float = 0.0
) -> dict[str, float]:
    if reading == "room":
        left = attenuation.ball_transmittance(tau, WALL[:-1], WALL[1:])
        rows = {_bin("radiance", WALL, i): RADIANCE for i in range(len(left))}
        rows |= {_bin("radiance, direct", WALL, i): RADIANCE * each for i, each in enumerate(left)}
        irradiance = math.pi * RADIANCE
        return rows | {IRRADIANCE: irradiance, DIRECT: irradiance * attenuation.ball_transmittance(tau)}
    if reading == "sun":
        return {SUN: SURFACE * attenuation.cone_transmittance(tau, zenith_angle, SUN_ANGLE)}
    radius, distance, size = LAMP if reading == "lamp" else DISK
    cosines = np.cos(_edges(reading))
    left = attenuation.mean_slant_transmittance(tau, cosines[1:-2], cosines[:-3]) * RADIANCE
    irradiance = attenuation.disk_irradiance(RADIANCE, radius, distance, tau, size)
    if reading == "lamp":
        return {DIRECT: irradiance, IN_LAMP: float(left[0])}
    rows = {_bin("radiance", cosines, i): float(left[i]) for i in range(BINS)}
    return rows | {IRRADIANCE: irradiance, "radiance beside the disk": 0.0}


def _bin(quantity: str, cosines: np.ndarray, index: int) -> str:
    low, high = sorted(cosines[index : index + 2])
    return f"{quantity}, cosθ {low:.3g} to {high:.3g}"


def verdict(outcomes: list[Outcome]) -> str:
    found = {reading: [o for o in outcomes if _given(o, "reading") == reading] for reading in READINGS}
    said = []
    if disks := found["disk"]:
        scores = [abs(row.z) for o in disks for row in o.rows if math.isfinite(row.z)]
        worst = f"{len(scores)} readings at most {max(scores, default=0):.1f} standard errors off"
        said.append(f"radiance is L exp(-τ/cosθ), {worst}")
        tau, irradiance = max((_given(o, "tau"), o[IRRADIANCE].estimate.value) for o in disks)
        many = guessed(tau) / irradiance if irradiance else math.inf
        said.append(
            f"exp(-τ) of the clear air's irradiance would be {many:.3g} times too much at τ = {tau:.3g}"
        )
    for o in found["lamp"]:
        total = o.result["view"].irradiance
        said.append(f"of a lamp's light in scattering fog {o[DIRECT].estimate} is direct, {total} all of it")
    for o in found["room"]:
        told = f"{o[IRRADIANCE].estimate} whatever its fog, of it {o[DIRECT].estimate} straight"
        said.append(f"the wall of a glowing room receives {told}")
    if suns := found["sun"]:
        seen = (f"{o[SUN].estimate} through τ = {_air(o):.2g}" for o in suns)
        said.append(f"the sun's radiance is {', '.join(seen)}")
    words = "; ".join(said)
    return f"{words[0].upper()}{words[1:]}."


def guessed(tau: float) -> float:
    """The wrong guess: irradiance in clear air times exp(-tau) [W m^-2]."""
    clear = attenuation.disk_irradiance(RADIANCE, *DISK[:2], 0.0, DISK[2])
    return clear * float(attenuation.transmittance(tau))


def _given(outcome: Outcome, name: str) -> object:
    """A parameter of the case, or its default."""
    defaults = {"reading": "disk", "tau": 1.0, "place": "slab", "zenith_angle": 0.0}
    return outcome.parameters.get(name, defaults[name])


def _air(outcome: Outcome) -> float:
    """Optical depth of the air before the sun."""
    return _given(outcome, "tau") / math.cos(_given(outcome, "zenith_angle"))


def _label(outcome: Outcome) -> str:
    return f"τ = {_given(outcome, 'tau'):.3g}, {_given(outcome, 'place')}"


def draw(outcomes: list[Outcome], path: str) -> list[Path]:
    """What the meter sees of the disk; beside it <name>_ways, _irradiance, _lamp, _room and _sun, where there are such."""
    path, paths = Path(path), []
    pictures = {"disk": (draw_disk, draw_ways, draw_irradiance), "lamp": (draw_lamp,), "room": (draw_room,)}
    pictures["sun"] = (draw_sun,)
    for reading, functions in pictures.items():
        shown = [o for o in outcomes if _given(o, "reading") == reading]
        for function in functions if shown else ():
            word = function.__name__.removeprefix("draw_")
            paths.append(path.with_stem(f"{path.stem}_{word}") if paths else path)
            function(shown, paths[-1])
    return paths


def _small_print(outcomes: list[Outcome]) -> str:
    """Of what is aimed and absorbed only: cases of one seed have the same rays, and deviate together."""
    return provenance(outcomes) + ("; the same rays in every case" if len(outcomes) > 1 else "")


def draw_disk(outcomes: list[Outcome], path: Path) -> None:
    """The disk as the meter sees it, from clear air to thick fog."""
    from transport.viz.views import views

    seen = {_label(o): o.result["view"].radiance for o in outcomes}
    laws = {_label(o): partial(_direct, tau=_given(o, "tau"), of=DISK) for o in outcomes}
    title = "A bright disk seen through fog: radiance is not invariant there"
    views(seen, path, exact=laws, title=title, note=_small_print(outcomes))


def draw_lamp(outcomes: list[Outcome], path: Path) -> None:
    """A lamp in scattering fog: all light, and what of it came straight."""
    from transport.viz.views import views

    tau, result = _given(outcomes[0], "tau"), outcomes[0].result
    seen = {"all light": result["view"].radiance, "direct": result["direct view"].radiance}
    laws = {"direct": partial(_direct, tau=tau, of=LAMP)}
    title = f"A lamp in fog that scatters, τ = {tau:.3g}: its light glows about it"
    views(seen, path, exact=laws, title=title, log=True, note=provenance(outcomes))


def _direct(theta: np.ndarray, tau: float, of: tuple[float, float, float]) -> np.ndarray:
    """Radiance that comes straight from the disk or the lamp."""
    return attenuation.disk_radiance(theta, RADIANCE, *of[:2], tau, of[2])


def draw_ways(outcomes: list[Outcome], path: Path) -> None:
    """Radiance over that in clear air against the optical depth of the way: one exponential for all."""
    from transport.viz.catalogue import Entry, catalogue

    cosines = np.cos(_edges("disk"))[: BINS + 1]
    middles, entries = (cosines[1:] + cosines[:-1]) / 2, {}
    for outcome in outcomes:
        level = constant(outcome.result, RADIANCE, "W m^-2 sr^-1")
        rows = outcome.rows[:BINS]
        shares, expected = [r.estimate / level for r in rows], [r.exact / RADIANCE for r in rows]
        depths = _given(outcome, "tau") / middles
        entries[_label(outcome)] = Entry(depths, shares, lambda way: math.exp(-way), expected)
    catalogue(
        entries,
        path,
        xlabel="optical depth of the way  τ / cosθ",
        ylabel="radiance / that in clear air",
        title="Along every ray radiance falls by exp(-τ)",
        note=_small_print(outcomes),
        log_y=True,
    )


def draw_irradiance(outcomes: list[Outcome], path: Path) -> None:
    """Irradiance against the optical depth, with the guess that forgets the slant."""
    from transport.viz.profiles import profile

    profile(
        [_given(o, "tau") for o in outcomes],
        [o[IRRADIANCE].estimate for o in outcomes],
        path,
        exact=np.vectorize(lambda t: attenuation.disk_irradiance(RADIANCE, *DISK[:2], t, DISK[2])),
        guides={"wrong guess: exp(-τ) of that in clear air": np.vectorize(guessed)},
        xlabel="optical depth τ straight from the disk to the meter",
        ylabel="irradiance",
        title="Irradiance in fog falls faster than exp(-τ)",
        log_y=True,
        note=_small_print(outcomes),
    )


def draw_room(outcomes: list[Outcome], path: Path) -> None:
    """All rows of the room beside their exact values."""
    from transport.viz.comparisons import comparison

    table = {row.name: (row.estimate, row.exact) for row in outcomes[0].rows}
    title = "A glowing room full of fog: as bright as an empty one"
    comparison(table, path, title=title, note=provenance(outcomes))


def draw_sun(outcomes: list[Outcome], path: Path) -> None:
    """The sun's radiance against the depth of air before it."""
    from transport.viz.profiles import profile

    profile(
        [_air(o) for o in outcomes],
        [o[SUN].estimate for o in outcomes],
        path,
        exact=lambda depth: SURFACE * np.exp(-depth),
        guides={"at its surface, and above the air": lambda depth: np.full(np.shape(depth), SURFACE)},
        xlabel="optical depth of the air before the sun: τ / cos(zenith angle)",
        ylabel="radiance of the sun",
        title=f"The sun through the atmosphere, τ = {ATMOSPHERE:.2f} at the zenith",
        log_y=True,
        note=_small_print(outcomes),
    )


if __name__ == "__main__":
    from transport.sims import print_table

    print_table(__file__)
