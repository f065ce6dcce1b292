"""Faults that the rows of the course's experiments see: both ends of a ray, directions, clocks, sums of quantities."""

from tests.mutants.fault import Fault

ROWS = ("experiments/test_course_rows::test_rows_agree_with_few_particles",)
ANGLES, PLACES = "results/solid_angles.py", "engine/passes/detector_bins.py"

FAULTS = (
    Fault(
        ANGLES,
        "cone_projected_solid_angle(cone.half_angle, dot(cone.axis, n))",
        "cone_projected_solid_angle(cone.half_angle, 1.0)",
        "radiance that leaves an element without its cosine",
        ROWS,
    ),
    Fault(
        "sims/two_elements.py",
        "return etendue.tilted_throughput(one.center, sides_of(one), two.center, sides_of(two))",
        "return etendue.tilted_throughput(one.center, sides_of(one), two.center, sides_of(two)) / -two.normal[2]",
        "radiance that arrives at an element without its cosine",
        ROWS,
    ),
    Fault(
        ANGLES,
        "return plain[kept], projected[kept]",
        "return projected[kept], projected[kept]",
        "an intensity curve over the projected solid angle",
        ROWS,
    ),
    Fault(
        "geometry/polygon.py",
        "        return _triangles(self.vertices)\n\n    def _check",
        "        return _triangles(self.vertices)[1:]\n\n    def _check",
        "a star of one steradian that lacks a triangle",
        ROWS,
    ),
    Fault(
        "analysis/solid_angle.py",
        "np.full(len(result.run), 4 * math.pi)",
        "np.full(len(result.run), 4.0)",
        "solid angles without their π",
        ROWS,
    ),
    Fault(
        "scene/emissions.py",
        "self.density * self.crossing_speed(shape, is_back) if self.exitance is None else self.exitance\n"
        "        ) * shape.area",
        "self.density * self.crossing_speed(shape, is_back) if self.exitance is None else self.exitance\n"
        "        ) * shape.area / 4",
        "photons of a lamp over four times its area",
        ROWS,
    ),
    Fault(
        PLACES,
        "polar = azimuth_turn(w, math.sqrt(u * u + v * v)) * TWO_PI",
        "polar = azimuth_turn(w, abs(u)) * TWO_PI",
        "an area on a sphere that is a strip",
        ROWS,
    ),
    Fault(
        PLACES,
        "found = find_cell(lane.time, m.time_cells, lane.arena + m.time_edges)",
        "found = find_cell(0.8 * lane.time, m.time_cells, lane.arena + m.time_edges)",
        "a film that is exposed for longer than its shutter",
        ROWS,
    ),
    Fault(
        "engine/passes/velocities.py",
        "    lane.arrival = lane.time + (lane.distance - lane.start) * slowness\n",
        "    lane.arrival = lane.time + (lane.distance - lane.start) * slowness * 0.95\n",
        "light that is 5 % too fast in a room which it fills",
        ROWS,
    ),
    Fault(
        "engine/passes/detectors.py",
        "lane.bin = choose((lane.visited & via) == via, lane.bin, 0)",
        "lane.bin = choose((lane.visited | via) == via, lane.bin, 0)",
        "light that need not have come through the first element",
        ROWS,
    ),
    Fault(
        "sims/far_lamp.py",
        "seen = 2 * math.pi * share / (1 + np.sqrt(1 - share))",
        "seen = math.pi * share",
        "a lamp that is a point already, near a desk",
        ROWS,
    ),
    Fault(
        "sims/quantities.py",
        "PHOTON = PLANCK * tp.speed_of_light / WAVELENGTH",
        "PHOTON = PLANCK / WAVELENGTH",
        "a photon of the energy h/λ",
        ROWS,
    ),
)
