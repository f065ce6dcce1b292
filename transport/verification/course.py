"""The course: each statement of four introductions to radiometry, with the experiment that shows it.

A statement names the case and the row that measure it, and the picture to project.  The page
`guides/course.md` and `transport list --course` are made from this table (transport.cli.course).
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from transport.units import deg
from transport.validation import SceneError

SOURCES = {
    "B": "K. Bala, Cornell CS 6620, spring 2009, lecture 2: Radiometry (titles of slides)",
    "R": "T. Akenine-Möller, E. Haines, N. Hoffman, Real-Time Rendering, 3rd edition, 2008, 7.1 to 7.3",
    "S": "Scratchapixel, Introduction to Radiometry (paragraphs and figures)",
    "H": "P. Hanrahan, Stanford CS 348B, spring 2001, lecture 4: The Light Field (titles of slides)",
    "own": "no statement of these four: it completes another one",
}
PLANNED = {
    "mirages": "rays are straight",
    "wavelength": "a run has one wavelength",
    "photometry": "results are in watts",
    "polarisation": "light is unpolarised",
}
STATES = ("shown", "not yet", "planned")


@dataclass(frozen=True)
class Statement:
    """A statement of a source, and where it is shown.

    Parameters
    ----------
    text : str
        The statement, in our words.
    formula : str
        Its formula; empty if it has none.
    source : str
        Letters of SOURCES, each with the slide, section or figure.
    sim : str
        Name of the experiment that shows it.
    case : mapping
        Parameters of the case, one of the experiment's `cases()`.
    row : str
        Name of the row that measures it.
    picture : str
        File of the picture, as the experiment draws it.
    remark : str
        Note for the audience, for example why the measurement refutes the source.
    is_refuted : bool
        Whether the measurement refutes the statement.
    missing : str
        Missing row, picture or experiment; such a statement is not shown yet.
    planned : str
        Key of PLANNED, for a statement that the library cannot show.
    """

    text: str
    formula: str
    source: str
    sim: str = ""
    case: Mapping[str, object] = field(default_factory=dict)
    row: str = ""
    picture: str = ""
    remark: str = ""
    is_refuted: bool = False
    missing: str = ""
    planned: str = ""

    def __post_init__(self) -> None:
        is_shown = bool(self.sim and self.row and self.picture)
        if bool(self.planned) + bool(self.missing) + is_shown != 1:
            must = "sim, row and picture, or missing=, or planned="
            raise SceneError(f"course: {self.text!r} must have {must}")
        if self.planned not in ("", *PLANNED):
            raise SceneError(f"course: {self.text!r}: planned must be one of {', '.join(PLANNED)}")
        if not set(self.letters) <= set(SOURCES):
            raise SceneError(f"course: {self.text!r}: source must begin with one of {', '.join(SOURCES)}")

    @property
    def letters(self) -> list[str]:
        """The letters of its sources."""
        return [part.partition(" ")[0] for part in self.source.split("; ")]

    @property
    def state(self) -> str:
        """One of STATES."""
        return STATES[2] if self.planned else STATES[1] if self.missing else STATES[0]


@dataclass(frozen=True)
class Numbered:
    """A statement with its place in the course: "29b" is the second statement of topic 29."""

    label: str
    number: int
    chapter: str
    topic: str
    statement: Statement


def numbered() -> Iterator[Numbered]:
    """Yield all statements in the order of the course."""
    number = 0
    for chapter, topics in COURSE.items():
        for topic, statements in topics.items():
            number += 1
            for part, statement in enumerate(statements):
                letter = chr(ord("a") + part) if len(statements) > 1 else ""
                yield Numbered(f"{number}{letter}", number, chapter, topic, statement)


def counts() -> dict[str, int]:
    """Number of statements by state, of all, and of topics."""
    found = list(numbered())
    states = [each.statement.state for each in found]
    return {
        "topics": found[-1].number,
        "statements": len(found),
        **{state: states.count(state) for state in STATES},
    }


# Cases that several statements share.
STREAM = {"tilt": 60 * deg, "intervals": 4}
FROM_BEHIND = {"tilt": 120 * deg, "intervals": 1}
CLOSED = {"meter": "closed"}
ARCS = {"subject": "arc and area"}
DOME = {"subject": "dome"}
INTEGRALS = {"show": "integrals"}
AREA = {"show": "area"}
NEAR_LAMP = {"show": "photons", "distance": 1.0}
TURNED = {"reading": "turned", "distance": 1000.0, "tilt": 60 * deg}
GRAZING = {"reading": "turned", "distance": 1000.0, "tilt": 89.9 * deg}
THREE_WAYS = {"reading": "three ways"}
PANEL = {"show": "panel", "distance": 3.0}
SQUARES = {
    "show": "first law", "size_1": 0.05, "size_2": 0.02, "tilt_1": 75 * deg, "tilt_2": 45 * deg,
}  # fmt: skip
ZENITH = {"reading": "sun", "tau": math.log(2.3e7 / 1.4e7), "zenith_angle": 0.0}
EARTH, MARS = ({"planet": planet, "given": "solid angle"} for planet in ("Earth", "Mars"))


PARTICLES = {
    "Particles in phase space": (
        Statement(
            "A particle has a place and a velocity; n is the number of particles per volume of both",
            "n(x, v, t)",
            "H Particle Density",
            "phase_space", {"start": "waterbag"}, "n within the bag, t = 0.25 s", "phase_space_planes.png",
            remark="The row is of a bag in one place and one velocity; the picture shows planes of"
            " a cloud in all six.",
        ),
        Statement(
            "A density is a limit: a count per element, as the element shrinks",
            "n = lim N/(Δ³x Δ³v)",
            "H Particle Density",
            "limits", {"element": "area"}, "mean over ΔA = 3.125 mm", "limits.png",
            remark="Shown for elements of area, of directions and of time: too large is biased, too small is"
            " noisy. The exact value is the mean over the element.",
        ),
    ),
    "Which particles cross": (
        Statement(
            "The particles that cross dA within dt are those that start in the oblique prism v dt · dA",
            "",
            "H Flows",
            "flows", STREAM, "histories that differ", "flows_space.png",
        ),
    ),
    "Amount and flux": (
        Statement(
            "The prism has the volume of its base times its height",
            "d³x = (v dt)·dA = v cosθ dt dA",
            "H Flows",
            "flows", STREAM, "started in the prism", "flows_space.png",
            remark="The row is the number of particles in it, n d³x.",
        ),
        Statement(
            "The amount that crosses is the density times this volume",
            "Q = n (v dt)·dA",
            "H Flows",
            "flows", STREAM, "crossed within dt", "flows_space.png",
        ),
        Statement(
            "Flux is the amount per time",
            "Φ = dQ/dt = n v·dA",
            "H Flows, Flux",
            "flows", STREAM, "ΔQ/Δt, t/dt 0.5 to 1", "flows_time.png",
        ),
    ),
    "Flux density": (
        Statement(
            "Flux per area falls with the cosine of the tilt",
            "dΦ/dA = n v cosθ",
            "H Flows, Flux density",
            "flows", STREAM, "net", "flows_tilt.png",
        ),
    ),
    "Any stuff flows alike": (
        *(
            Statement(
                f"The same counts carry {stuff}",
                f"{symbol} n v cosθ",
                "H Transport Theory",
                "photon_gas", {"motion": "stream", "tilt": 60 * deg, "stuff": stuff}, "net",
                "photon_gas_stuff.png",
            )
            for stuff, symbol in (("mass", "m"), ("charge", "q"), ("energy", "hν"))
        ),
    ),
    "Closed surfaces": (
        Statement(
            "The net flux out of a closed surface is the power of the sources inside",
            "∮ n v·dA = sources inside",
            "own Gauss's theorem for the flux of H",
            "flows", CLOSED, "net, box", "flows_closed.png",
        ),
    ),
    "Flux through a region, during a time": (
        Statement(
            "Flux passes through a region of space: an empty region lets out as much as it receives",
            "Φ in = Φ out",
            "S fig. 1",
            "flows", CLOSED, "net, empty sphere", "flows_closed.png",
        ),
        Statement(
            "The time from t to t + Δt can be anything you like",
            "Φ = ΔQ/Δt",
            "S Radiant flux",
            "flows", STREAM, "ΔQ/Δt, t/dt 0 to 0.125", "flows_time.png",
            remark="In a steady flow; in a burst it must be short, as limits_seen.png shows.",
        ),
    ),
    "More photons": (
        Statement(
            "The more photons, the more energy",
            "Φ = hν dN/dt",
            "S Radiant flux",
            "quantities", NEAR_LAMP, "power through the pupil", "quantities_photons.png",
        ),
        Statement(
            "The more photons are counted, the better the number is known",
            "error ∝ 1/√N",
            "own after S Radiant flux",
            "flows", STREAM, "started in the prism", "flows_settling.png",
        ),
    ),
    "Name the area": (
        Statement(
            "Flux is extensive, so one must name the area: twice the area receives twice the flux",
            "Φ = E A",
            "S Radiant flux",
            "quantities", AREA, "Φ, twice the area", "quantities_area.png",
        ),
        Statement(
            "Flux per area is not extensive",
            "E = Φ/A",
            "S Radiant flux",
            "quantities", AREA, "E, twice the area", "quantities_area.png",
        ),
    ),
}  # fmt: skip

ANGLES = {
    "Angle": (
        Statement(
            "An angle is a length on a circle over its radius",
            "θ = s/r",
            "B Solid angles, 2D; H Angles and Solid Angles",
            "directions", ARCS, "θ of an arc of 1, r = 2", "directions_arcs.png",
        ),
        Statement(
            "A full circle has 2π radians",
            "2π",
            "B Solid angles, 2D; H Angles and Solid Angles",
            "directions", ARCS, "θ of a full circle, arcs of s = r", "directions_arcs.png",
            remark="Counted are all directions over those that meet an arc of one radian.",
        ),
    ),
    "Solid angle": (
        Statement(
            "A solid angle is an area on a sphere over its radius squared",
            "Ω = A/r²",
            "B Solid angles, 3D; H Angles and Solid Angles",
            "directions", ARCS, "Ω of an area of 1, r = 2", "directions_arcs.png",
        ),
        Statement(
            "A full sphere has 4π = 12.566 steradians",
            "∫dω = 4π",
            "B Solid angle; H Angles and Solid Angles",
            "directions", ARCS, "Ω of a full sphere, areas of A = r²", "directions_arcs.png",
        ),
    ),
    "Areas that are not on the sphere": (
        Statement(
            "An area that is not on the sphere counts by its projection onto the unit sphere",
            "Ω = area of the projection",
            "H Angles and Solid Angles",
            "directions", {"subject": "square"}, "solid angle", "directions.png",
        ),
    ),
    "One steradian": (
        Statement(
            "The shape is irrelevant to the solid angle: a cone, a square and a star of 1 sr count the same",
            "Ω = 1 sr",
            "R fig. 7.3",
            "directions", {"subject": "one steradian"}, "star / cone", "directions_steradian.png",
        ),
    ),
    "A dodecahedron's face": (
        Statement(
            "A face of a dodecahedron fills 1 sr",
            "4π/12",
            "B Solid angle",
            "directions", {"subject": "dodecahedron"}, "a dodecahedron's face", "directions.png",
            remark="It fills 4π/12 = 1.0472 sr: nearly a steradian, not one.",
            is_refuted=True,
        ),
    ),
    "Differential solid angle": (
        Statement(
            "A direction is a point of the unit sphere",
            "(θ, φ)",
            "B Hemispheres; B Hemispherical coordinates",
            "directions", {"subject": "octant"}, "solid angle", "directions.png",
        ),
        Statement(
            "An element of solid angle shrinks towards the poles",
            "dω = sinθ dθ dφ",
            "B Hemispherical coordinates; H Differential Solid Angles",
            "directions", {"subject": "isotropic"}, "χ²/(K − 1)", "directions_hemisphere.png",
        ),
        Statement(
            "A hemisphere has 2π steradians",
            "∫dω = 2π",
            "B Hemispherical integration",
            "directions", {"subject": "isotropic"}, "∫dω, θ ≤ 90°", "directions_caps.png",
        ),
        Statement(
            "With the cosine a hemisphere has π",
            "∫cosθ dω = π",
            "B Example: Diffuse emitter",
            "directions", DOME, "∫cosθ dω, onto a disk", "directions_caps.png",
        ),
    ),
}  # fmt: skip

QUANTITIES = {
    "Energy and power": (
        Statement(
            "Energy Q is in joules",
            "Q",
            "B Power; S Radiant energy",
            "quantities", INTEGRALS, "Q, energy on the meter", "quantities.png",
        ),
        Statement(
            "Power Φ, or radiant flux, is energy per time, in watts",
            "Φ = dQ/dt",
            "B Power; S Radiant flux",
            "quantities", INTEGRALS, "Φ on the meter", "quantities.png",
        ),
        Statement(
            "All further quantities are derivatives of power",
            "d/dA, d/dω",
            "B Power",
            "quantities", INTEGRALS, "I of the lamp", "quantities.png",
        ),
    ),
    "Light is fast": (
        Statement(
            "Light is so fast that one may ignore the difference of power and energy",
            "W(t) → Φ t̄",
            "H Radiant Energy and Power",
            "light_fills_a_room", {"albedo": 0.5}, "energy after 80.1 ns", "light_fills_a_room.png",
            remark="A room is full of light within tens of nanoseconds.",
        ),
    ),
    "Exposure": (
        Statement(
            "Film and skin respond to the exposure: a quarter of the light for four times the time",
            "H = ∫E dt",
            "H Radiant Energy and Power, Exposure",
            "quantities", {"show": "exposure"}, "H, f/4 for 1/8 s over f/8 for 1/2 s",
            "quantities_exposure.png",
        ),
    ),
    "Energy of a photon": (
        Statement(
            "A photon has the energy hν, so that a lamp's power is a number of photons per second",
            "E = hν = hc/λ",
            "S Radiant energy; B Power",
            "quantities", NEAR_LAMP, "photons a second, pupil", "quantities_photons.png",
        ),
        Statement(
            "A particle of the wavelength λ has E = h/λ",
            "E = h/λ",
            "B Wavelength Dependence",
            "quantities", {"show": "photons", "distance": 1e3}, "photons a second, pupil",
            "quantities_photons.png",
            remark="A slip: h/λ is the momentum. Dashed: the number of photons that it would give.",
            is_refuted=True,
        ),
    ),
    "Irradiance": (
        Statement(
            "Irradiance is power per area",
            "E = dΦ/dA",
            "B Irradiance; S Irradiance",
            "quantities", AREA, "E, patch of 50 dm²", "quantities_area.png",
        ),
        Statement(
            "It is measured by a detector of small area",
            "E = lim ΔΦ/ΔA",
            "B Irradiance; S Irradiance, fig. 2",
            "limits", {"element": "area"}, "mean over ΔA = 12.5 mm", "limits_seen.png",
        ),
    ),
    "The hemisphere below": (
        Statement(
            "Light is collected for the hemisphere below P too, if the surface is transparent",
            "",
            "S Irradiance",
            "gonioreflectometer", {"sample": "paper"}, "f behind it at 42° to 48°", "gonioreflectometer.png",
            remark="Paper: the orange lobe is below.",
        ),
    ),
    "Exitance and radiosity": (
        Statement(
            "Power per area that exits a surface, exitance M or radiosity B, has the unit of irradiance",
            "M = dΦ/dA",
            "B Irradiance",
            "quantities", INTEGRALS, "M of the lamp", "quantities.png",
        ),
    ),
    "Intensity": (
        Statement(
            "Intensity is power per solid angle",
            "I = dΦ/dω",
            "B Intensity; S Radiant intensity",
            "goniophotometer", {"lamp": "disk"}, "I, θ 52.5° to 60°", "goniophotometer.png",
        ),
        Statement(
            "A uniform source has the same intensity in all directions",
            "I = P/4π",
            "B Intensity",
            "goniophotometer", {"lamp": "sphere"}, "I, θ 75° to 82.5°", "goniophotometer.png",
        ),
        Statement(
            "Intensity describes how a lamp varies with direction",
            "I(ω)",
            "R 7.1, before eq. 7.4",
            "goniophotometer", {"lamp": "tube"}, "I, θ 26.25° to 30°", "goniophotometer.png",
        ),
    ),
    "Point source": (
        Statement(
            "A point source spreads its power over a sphere, so that irradiance falls with the square",
            "E = P/4πr²",
            "B Irradiance example; R 7.1, before eq. 7.4; S Irradiance",
            "inverse_square", {"emitter": "point"}, "E(1 mm) / E(1 km)", "inverse_square.png",
        ),
    ),
    "Directional light": (
        Statement(
            "A lamp that is far away compared with the scene is a directional light",
            "E(rim)/E(middle) → 1",
            "R 7.1, before eq. 7.4",
            "far_lamp", {"height": 16.0}, "E at the rim / in the middle", "far_lamp.png",
        ),
    ),
    "The five-times rule": (
        Statement(
            "From five times its width a lamp obeys the inverse square law",
            "E d²/I → 1",
            "R 7.1, before eq. 7.4 (Lambert 1760)",
            "inverse_square", {"emitter": "disk", "widths": 5.0}, "irradiance / inverse square",
            "inverse_square_rule.png",
            remark="Five diameters from a disk it holds to 1 %; a sphere obeys the law at any distance.",
        ),
    ),
    "Radiance": (
        Statement(
            "Radiance is power per projected area and per solid angle",
            "L = d²Φ/(dA⊥ dω)",
            "B Radiance; R eq. 7.4; S Radiance, eq. 1; H Radiance and Luminance",
            "lambert_disk", THREE_WAYS, "d²Φ/dA⊥dω", "lambert_disk_ways.png",
        ),
        Statement(
            "It is a function of five variables: place and direction",
            "L(x, y, z, θ, φ)",
            "B Radiance; R 7.1, after fig. 7.5; S Radiance",
            "quantities", {"show": "plenoptic", "place": "near"}, "L at (0, 0, 1) m, to the lamp, after",
            "quantities_plenoptic.png",
        ),
    ),
    "Radiance from irradiance and from intensity": (
        Statement(
            "Radiance is irradiance on a plane across the ray, per solid angle",
            "L = dE⊥/dω",
            "R eq. 7.6, fig. 7.5; B Radiance; S Radiance",
            "lambert_disk", THREE_WAYS, "dE⊥/dω", "lambert_disk_ways.png",
            remark="The exact value is of a cone of 25°; it tends to L = 100 as the cone shrinks.",
        ),
        Statement(
            "Radiance is intensity per projected area",
            "L = dI/dA⊥",
            "R eq. 7.6, fig. 7.5; S Radiance",
            "lambert_disk", THREE_WAYS, "dI/dA⊥", "lambert_disk_ways.png",
            remark="The exact value is of a cone of 25°; it tends to L = 100 as the cone shrinks.",
        ),
    ),
    "Projected area": (
        Statement(
            "A sheet that is turned away shows less area, and receives less",
            "dA⊥ = dA cosθ",
            "S eq. 2, fig. 9, 10; R eq. 7.5; B Radiance: Projected area",
            "lambert_disk", TURNED, "irradiance", "lambert_disk_sheets.png",
        ),
        Statement(
            "The footprint of a narrow beam grows with the tilt",
            "1/cosθ",
            "S fig. 8",
            "directions", {"subject": "footprint", "tilt": 60 * deg}, "footprint / face on",
            "directions_footprint.png",
        ),
        Statement(
            "Per projected area a turned sheet sees the same photons as one across the rays",
            "d²Φ/(dA cosθ dω) = L",
            "B Radiance: Oblique surface; S Radiance",
            "lambert_disk", TURNED, "radiance, cone in the disk", "lambert_disk_sheets.png",
        ),
    ),
    "The clamped cosine": (
        Statement(
            "The cosine is clamped to zero: light from behind does not count on this side",
            "max(cosθ, 0)",
            "R eq. 7.5",
            "flows", FROM_BEHIND, "against the normal", "flows_tilt.png",
            remark="It counts on the other side.",
        ),
    ),
    "Radiance at grazing angles": (
        Statement(
            "When the cosine goes to 0, radiance goes to infinity",
            "L ∝ 1/cosθ ?",
            "S Radiance, question from a reader",
            "lambert_disk", GRAZING, "radiance, cone in the disk", "lambert_disk_turned.png",
            remark="It does not: the flux falls with the same cosine. Dashed: the source's answer.",
            is_refuted=True,
        ),
    ),
    "Two facing elements": (
        Statement(
            "All light of an element falls on an equal one that faces it",
            "F = 1 ?",
            "S Radiance, before fig. 8",
            "view_factors", {"pair": "disks", "ratio": 10.0}, "F₁₂", "view_factors_facing.png",
            remark="A slip, true only if they touch: five diameters apart a disk receives 1 % of an"
            " equal one's light.",
            is_refuted=True,
        ),
    ),
    "Incident and exitant radiance": (
        Statement(
            "Radiance leaves a surface: its direction points away from it",
            "L(x → ω)",
            "S fig. 13, 14",
            "quantities", {"show": "facing"}, "L leaving the lamp, ω to the receiver",
            "quantities_facing.png",
        ),
        Statement(
            "Radiance arrives at a surface: its direction points away from it too",
            "L(x ← ω)",
            "S fig. 13, 14",
            "quantities", {"show": "facing"}, "L at the receiver, ω to the lamp", "quantities_facing.png",
        ),
    ),
    "Radiance varies with direction": (
        Statement(
            "Around a point radiance varies strongly with direction, as between a window and a plant",
            "L(ω)",
            "S fig. 12",
            "panorama", {"projection": "latitude-longitude"}, "irradiance E to the window", "panorama.png",
        ),
    ),
    "Fluence": (
        Statement(
            "Fluence counts all particles that pass a small ball, from whatever direction",
            "φ = ∫L dω = Φ/πr²",
            "S Irradiance, scalar irradiance",
            "lambert_disk", {"reading": "ball", "distance": 0.5, "ball": 0.1}, "fluence rate, Φ/πr²",
            "lambert_disk_balls.png",
        ),
    ),
    "All quantities derive from radiance": (
        Statement(
            "Irradiance is the sum of radiance over directions",
            "E = ∫L cosθ dω",
            "B Relationships; H Properties of Radiance",
            "quantities", INTEGRALS, "∫L cosθ dω, the meter", "quantities.png",
        ),
        Statement(
            "Power is the sum over directions and area",
            "P = ∬L cosθ dω dA",
            "B Relationships; H Properties of Radiance",
            "quantities", INTEGRALS, "∬L cosθ dω dA, the meter", "quantities.png",
        ),
        Statement(
            "Radiosity is the sum of the radiance that leaves",
            "B = ∫L cosθ dω",
            "B Relationships",
            "quantities", INTEGRALS, "∫L cosθ dω, the lamp", "quantities.png",
        ),
    ),
    "Diffuse emitter": (
        Statement(
            "A diffuse emitter has equal radiance everywhere, in all directions",
            "L(x → ω) = L",
            "B Example: Diffuse emitter",
            "directions", {"subject": "cosine law"}, "χ²/(K − 1)", "directions_radiance.png",
        ),
        Statement(
            "Its radiosity is π times its radiance",
            "B = π L",
            "B Example: Diffuse emitter",
            "quantities", INTEGRALS, "M of the lamp", "quantities.png",
        ),
        Statement(
            "Its power is the area times that",
            "P = π L A",
            "B Example: Diffuse emitter",
            "quantities", INTEGRALS, "Φ of the lamp", "quantities.png",
        ),
    ),
}  # fmt: skip

LAWS = {
    "First law: radiance along a ray": (
        Statement(
            "Radiance is invariant along a ray, however far away the source is",
            "L = L",
            "B Why is radiance important?; R 7.1, after fig. 7.5; H Radiance: 1st Law",
            "lambert_disk", {"distance": 20.0}, "radiance in the disk, θ 0° to 0.7153°", "lambert_disk.png",
        ),
    ),
    "The same rays at both ends": (
        Statement(
            "The rays that leave one element for another arrive there, so that both radiances are equal",
            "L₁ dω₁ dA₁ cosθ₁ = L₂ dω₂ dA₂ cosθ₂",
            "H Radiance: 1st Law; B Invariance of Radiance",
            "two_elements", SQUARES, "L₁/L₂", "two_elements_laws.png",
            remark="Each end is measured with particles of its own.",
        ),
    ),
    "Second law: a sensor": (
        Statement(
            "The response of a sensor is proportional to the radiance of the surface that it sees",
            "R = L T",
            "H Radiance: 2nd Law; B Why is radiance important?; S Radiance",
            "throughput", {"show": "sensor", "distance": 5.0}, "R/T, 0.1 m behind the hole",
            "throughput_laws.png",
        ),
    ),
    "Pixels": (
        Statement(
            "Pixel values are proportional to the radiance received from that direction",
            "pixel ∝ L",
            "B Why is radiance important?; S Radiance",
            "camera", {"place": "room"}, "lamp", "camera.png",
        ),
        Statement(
            "An image is a two-dimensional set of rays",
            "L(u, v)",
            "H Properties of Radiance",
            "camera", {"place": "room"}, "lamp", "camera.png",
        ),
    ),
    "Throughput": (
        Statement(
            "Throughput counts the rays of a beam",
            "T = ∬cosθ dω dA",
            "H Throughput",
            "two_elements", {"show": "lines", "size_1": 1.0, "size_2": 1.0}, "T, lines by dA₁ to dA₂",
            "two_elements_laws.png",
        ),
        Statement(
            "It is conserved along straight lines",
            "T = T",
            "H Throughput",
            "two_elements", {"show": "throughput", "size_1": 1.0, "size_2": 2.0}, "T through the plane, up",
            "two_elements_laws.png",
        ),
        Statement(
            "It is conserved by reflection",
            "T = T",
            "H Throughput",
            "throughput", {"show": "spherical mirror"}, "T, rays from 2 to 1", "throughput_laws.png",
        ),
        Statement(
            "It is conserved by refraction",
            "T = T",
            "H Throughput",
            "throughput", {"show": "glass ball"}, "T, rays from 2 to 1", "throughput_laws.png",
        ),
    ),
    "Mirages": (
        Statement(
            "Throughput is conserved by mirages",
            "T = T",
            "H Throughput",
            planned="mirages",
        ),
    ),
    "Radiance is energy over throughput": (
        Statement(
            "Radiance is energy over throughput, and both are conserved",
            "L = d²Φ/dT",
            "H Throughput",
            "throughput", {"show": "lens"}, "T, rays from 2 to 1", "throughput.png",
            remark="The beam changes its shape, and keeps its area and its radiance.",
        ),
    ),
    "Quiz 1": (
        Statement(
            "Does radiance increase under a magnifying glass? No",
            "L' = L",
            "H Quiz 1",
            "magnifier", {"optic": "ideal lens"}, "radiance behind, outer third of the cone",
            "magnifier.png",
        ),
    ),
    "Quiz 2": (
        Statement(
            "Does the brightness of a wall depend on the distance of the viewer? No",
            "R/(L T) = 1",
            "H Quiz 2; R 7.1, after fig. 7.5",
            "wall_distance", {"show": "lens", "distance": 4.0}, "R / L T, middle cell",
            "wall_distance_retina.png",
        ),
    ),
    "The square panel": (
        Statement(
            "Twice as far from a square panel a quarter of the photons arrives",
            "E(2d)/E(d) → 1/4",
            "R 7.1, after fig. 7.5",
            "wall_distance", PANEL, "E(2d) / E(d)", "wall_distance_panel.png",
        ),
        Statement(
            "The radiance from any point of it is the same",
            "L(2d) = L(d)",
            "R 7.1, after fig. 7.5",
            "wall_distance", PANEL, "L(2d) / L(d)", "wall_distance_panel.png",
        ),
        Statement(
            "Its solid angle drops to about a quarter",
            "Ω(2d)/Ω(d) → 1/4",
            "R 7.1, after fig. 7.5",
            "wall_distance", PANEL, "Ω(2d) / Ω(d)", "wall_distance_panel.png",
        ),
    ),
    "Equilibrium": (
        Statement(
            "What are the conditions for equilibrium flow? The same L/n² in all directions, everywhere",
            "L/n² = L₀",
            "H Radiometry, question 4",
            "furnace", {}, "χ² of all bins / expectation", "furnace.png",
        ),
    ),
    "Reflection": (
        Statement(
            "How is reflection characterised? By radiance out per irradiance in, for each pair of directions",
            "f = dL_out/dE_in",
            "H Radiometry, question 3; S after fig. 14",
            "gonioreflectometer", {"sample": "gloss"}, "f at 42° to 48°", "gonioreflectometer.png",
        ),
        Statement(
            "The rendering equation: radiance out is the sum over radiance in",
            "L_out = ∫f L_in cosθ dω",
            "B What is the behavior of light?",
            "gonioreflectometer", {"show": "lamp", "sample": "gloss"}, "L_out at 42° to 48°",
            "gonioreflectometer_laws.png",
        ),
    ),
    "Geometric optics": (
        Statement(
            "Light travels in straight lines",
            "",
            "B Geometric Optics: Properties",
            "penumbra", {"occluder": "edge"}, "penumbra, x 0 to 25 mm", "penumbra.png",
        ),
        Statement(
            "Rays do not interact: two lamps give the sum",
            "E = E₁ + E₂",
            "B Geometric Optics: Properties",
            "quantities", {"show": "superposition"}, "E both lamps, in the middle",
            "quantities_superposition.png",
        ),
        Statement(
            "Rays have a colour, which is their wavelength",
            "λ",
            "B Geometric Optics: Properties",
            planned="wavelength",
        ),
    ),
    "Fog": (
        Statement(
            "Radiance is not affected by distance, but for atmospheric effects such as fog",
            "L exp(−τ)",
            "R 7.1, after fig. 7.5; B Why is radiance important? (in vacuum)",
            "fog", {"reading": "disk", "tau": 1.0, "place": "box"}, "radiance, cosθ 0.78 to 1", "fog.png",
        ),
    ),
    "The sun through the atmosphere": (
        Statement(
            "The radiance of the sun at its surface is 2.3e7 W m⁻² sr⁻¹",
            "L",
            "S after fig. 14",
            "fog", {"reading": "sun", "tau": 0.0}, "radiance of the sun", "fog_sun.png",
            remark="The other lecture has 2.05e7, the mean over the disk. By limb darkening the middle of the"
            " disk is brighter than its mean: a likely reason, which we infer.",
        ),
        Statement(
            "From the Earth's surface it is 1.4e7 W m⁻² sr⁻¹",
            "L exp(−τ)",
            "S after fig. 14",
            "fog", ZENITH, "radiance of the sun", "fog_sun.png",
            remark="The depth of the air is inferred from these two numbers.",
        ),
    ),
    "The sun": (
        Statement(
            "Power and area of the sun give its radiance, 2.05e7 W m⁻² sr⁻¹",
            "L = P/(π A)",
            "B Sun Example: radiance",
            "sun", EARTH, "radiance", "sun.png",
        ),
        Statement(
            "1 m² on the Earth receives 1373.5 W, the sun in the zenith",
            "P = L A Ω",
            "B Sun Example: Power on Earth",
            "sun", EARTH, "power on 1 m^2", "sun.png",
            remark="By the lecture's 6.7e-5 sr; the picture takes the solid angle from the distance. Measured"
            " today are 1361 W.",
        ),
        Statement(
            "1 m² on Mars receives 598.6 W",
            "P = L A Ω",
            "B Sun Example: Power on Mars",
            "sun", MARS, "power on 1 m^2", "sun.png",
            remark="By the lecture's 2.92e-5 sr; the picture takes the solid angle from the distance.",
        ),
    ),
    "Earth and Mars": (
        Statement(
            "Same radiance on Earth and Mars? Yes: the sun looks smaller, and just as bright",
            "L = L",
            "B Sun Example",
            "sun", {"planet": "Mars", "given": "distance"}, "radiance", "sun.png",
        ),
    ),
    "The shadow of a cylinder": (
        Statement(
            "Across the boundary of a shadow irradiance is not constant",
            "E(x)",
            "S fig. 3",
            "penumbra", {"occluder": "cylinder", "gap": 0.7, "thickness": 0.03},
            "penumbra, x 32.23 to 43.01 mm", "penumbra.png",
        ),
        Statement(
            "An element that includes both regions gives a wrong result",
            "mean over ΔA ≠ E(x)",
            "S fig. 3",
            "limits", {"element": "area"}, "mean over ΔA = 100 mm", "limits_seen.png",
            remark="The exact value is the mean over 100 mm; at the point it is 0.0383 W m⁻².",
        ),
    ),
    "Elements of solid angle": (
        Statement(
            "An element of solid angle must be so small that light comes from a single surface",
            "mean over Δω ≠ L(ω)",
            "S fig. 3, 4",
            "limits", {"element": "solid angle"}, "mean over Δω = 45.84°", "limits_seen.png",
            remark="The exact value is the mean over 45.84°; at the point it is 90.9 W m⁻² sr⁻¹.",
        ),
    ),
}  # fmt: skip

FIELDS = {
    "Environment maps": (
        Statement(
            "An environment map is the radiance at a point, in all directions",
            "L(θ, φ)",
            "H Environment Maps = Radiance at a Point",
            "panorama", {"projection": "latitude-longitude"},
            "fluence rate φ", "panorama.png",
            remark="One room in six projections; below each its fluence rate.",
        ),
    ),
    "Forms of environment maps": (
        Statement(
            "A cylindrical panorama shows it on a cylinder",
            "L(φ, z)",
            "H Environment Maps",
            "panorama", {"projection": "cylinder"},
            "irradiance E to the window", "panorama.png",
            remark="Rows of equal height in z = cos θ are equal solid angles.",
        ),
        Statement(
            "A cubical environment map shows it on six faces",
            "L(face, u, v)",
            "H Environment Maps",
            "panorama", {"projection": "cube"},
            "irradiance E upward", "panorama.png",
        ),
        Statement(
            "A fisheye of 180 degrees shows a hemisphere of it",
            "L(r, φ)",
            "H Environment Maps",
            "panorama", {"projection": "fisheye"},
            "E upward, by a fisheye of 180°", "panorama.png",
            remark="Irradiance on a plane needs no more than a hemisphere; a circle marks it in the picture.",
        ),
        Statement(
            "A mirrored ball shows nearly all of it",
            "L(mirrored)",
            "H Environment Maps (Miller, Hoffman 1984)",
            "panorama", {"projection": "photograph of a ball"},
            "irradiance E aslant", "panorama_ball.png",
            remark="A real mirror ball of 0.1 mm, photographed from 2.2 m; it hides what lies behind it.",
        ),
    ),
    "Light fields": (
        Statement(
            "A spherical light field captures all the light that leaves an object, like a hologram",
            "L(u, v, θ, φ)",
            "H Spherical Light Field",
            "light_field", {"show": "cube"}, "Φ through the sphere", "light_field_sphere.png",
            remark="Of a cube with bright and dark faces; bins of place and direction limit what is sharp.",
        ),
        Statement(
            "A two-plane light field captures rays by where they cross two planes",
            "L(u, v, s, t)",
            "H Two-Plane Light Field",
            "light_field", {"show": "view"}, "χ²/(number of pixels)", "light_field.png",
            remark="It holds pictures: one of them and a camera's differ by chance alone, so that χ² is 1.",
        ),
        Statement(
            "A two-dimensional array of cameras is a two-dimensional array of images",
            "L(u, v, s, t)",
            "H Two-Plane Light Field",
            "light_field", {"show": "parallax"}, "distance of the near disk", "light_field_array.png",
            remark="Near things move from picture to picture, and by how much gives their distance.",
        ),
    ),
    "The plenoptic function": (
        Statement(
            "Five variables, three of place and two of direction, describe all light that travels in space",
            "L(x, y, z, θ, φ)",
            "R 7.1, after fig. 7.5; S Radiance",
            "quantities", {"show": "plenoptic", "place": "aside"},
            "L at (1, 0.5, 1.5) m, to the lamp, after", "quantities_plenoptic.png",
            remark="And of time: the lamp is seen when its light arrives.",
        ),
        Statement(
            "Wavelength is the sixth variable",
            "L(x, y, z, θ, φ, λ)",
            "R 7.1, after fig. 7.5",
            planned="wavelength",
        ),
    ),
}  # fmt: skip

EYE = {
    "Spectra": (
        Statement(
            "All quantities depend on wavelength; radiance is the sum of spectral radiance",
            "L = ∫L_λ dλ",
            "B Wavelength Dependence; S Radiance",
            planned="wavelength",
        ),
        Statement(
            "Most programs use a colour model of red, green and blue",
            "",
            "S Radiance",
            planned="wavelength",
        ),
        Statement(
            "Light is visible from 380 to 780 nm",
            "",
            "R 7.3",
            planned="wavelength",
        ),
    ),
    "Photometry": (
        Statement(
            "Photometry weights radiometry by the sensitivity of the eye, a bell about 555 nm",
            "Φ_v = K_m ∫Φ_λ V(λ) dλ",
            "R 7.2, fig. 7.6; H Radiometry vs. Photometry",
            planned="photometry",
        ),
        Statement(
            "An eye adapted to the dark has its curve about 507 nm; 3.4 and 0.034 cd/m² are the limits",
            "V′(λ)",
            "R 7.2, footnote 3",
            planned="photometry",
        ),
        Statement(
            "Talbot, lumen, lux, candela, nit and foot-candle",
            "",
            "R table 7.2; H Radiant Energy and Power; H Radiance and Luminance",
            planned="photometry",
        ),
        Statement(
            "Watts and lumens: energy efficiency and spectral efficacy",
            "",
            "H Radiant Energy and Power",
            planned="photometry",
        ),
        Statement(
            "Green light appears brighter than red or blue",
            "",
            "R 7.2",
            planned="photometry",
        ),
    ),
    "Luminance of things": (
        Statement(
            "LCD 150 to 280 nits, CRT 50 to 150, sky 8000, a bulb 120 000, the sun at the horizon 600 000",
            "",
            "R 7.2",
            planned="photometry",
        ),
    ),
    "Brightness": (
        Statement(
            "Brightness is the perceived sensation, in brils",
            "B = Y^(1/3)",
            "H Radiometry vs. Photometry",
            planned="photometry",
        ),
    ),
    "Colour": (
        Statement(
            "Three types of cones: three numbers represent any spectrum that is seen",
            "",
            "R 7.3",
            planned="wavelength",
        ),
        Statement(
            "Humans distinguish about 10 million colours",
            "",
            "R 7.3",
            planned="wavelength",
        ),
    ),
    "Polarisation": (
        Statement(
            "Light is polarised",
            "",
            "H The Light Field",
            planned="polarisation",
        ),
    ),
}  # fmt: skip

Topics = dict[str, tuple[Statement, ...]]  # statements that belong together, by title

COURSE: dict[str, Topics] = {
    "Particles": PARTICLES,
    "Angles": ANGLES,
    "Quantities": QUANTITIES,
    "Laws": LAWS,
    "Fields": FIELDS,
    "Eye": EYE,
}
