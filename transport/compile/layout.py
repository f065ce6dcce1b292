"""How a compiled scene lies in memory: the record types of the passes' tables and the bits of a hit.

A hit is one int64: which sheet, which acting surface of which material, and which meters cover the point.

    bits 0-25   meters of the sheet that cover the point (bit l: layer l)
    bits 26-27  nothing lies in front of the sheet, or behind it
    bit  28     the point lies within rounding of its rectangle's edge
    bits 29-31  material of the acting surface
    bits 32-47  row of the acting surface; 0: none
    bits 48-62  sheet; a hit of 0 is no hit
"""

import numpy as np

METERS_A_SHEET = 26
NOTHING_BEFORE, NOTHING_BEHIND = 1 << 26, 1 << 27
EDGE = 1 << 28
MATERIAL_SHIFT, MATERIAL_MASK = 29, 7
SURFACE_SHIFT, SURFACE_MASK = 32, 0xFFFF
SHEET_SHIFT = 48

TRANSPARENT, BLACK, DIFFUSE, MIRROR, DIELECTRIC, GLOSSY, LENS = range(7)  # materials

ROUNDING = 2.0**-50  # bounds the relative rounding of a crossing's position: four units in the last place

# below this cosine a crossing counts 2/GRAZING_CUT instead of 1/|mu| towards the fluence rate
GRAZING_CUT = 1e-3

COUNT_BITS = 36  # of a row's number of scores; above them is what grazes it (engine/grazing.py)

# The ledger's rows of four words (high, low, number where it is asked for, spare or, of LOST: crossings from a medium that the scene contradicts, of BORN: the bits of the heaviest birth towards an aim); the absorbed weight follows, a row for each surface, then one for each row of MEDIA.
BORN, ESCAPED, IN_FLIGHT, ROULETTE, LOST, ABSORBED = 0, 1, 2, 3, 4, 5

# Where a lane stands: the sheet that its ray began on, that of the meter that it passed last on it (0: none), and
# whether that was out of a box.
STANDING, OUT, PASSED_SHIFT = 0x7FFF, 1 << 15, 16

NO_TABLE = np.dtype([("unused", "f8")])
ROWS = np.dtype(
    [("rows", "i8"), ("count", "i8")]
)  # address and length of an array of one of the row types below
TWO_ROWS = np.dtype(
    [("rows", "i8"), ("count", "i8"), ("others", "i8"), ("other_count", "i8")]
)  # and that of a second one
MOVED = np.dtype([("fields", "i8"), ("count", "i8")])  # address of the numbers of the fields to move
CODE = np.dtype([("code", "i8")])


def _floats(names: str) -> list[tuple[str, str]]:
    return [(name, "f8") for name in names.split()]


def _integers(names: str) -> list[tuple[str, str]]:
    return [(name, "i8") for name in names.split()]


# All lengths in scene lengths.  e_u, e_v, n: the local frame of shapes.FlatShape.frame.
FRAME = "cx cy cz eux euy euz evx evy evz nx ny nz"

# s: a point of the sheet; all its meters are met at the distance of that one point's plane (normal n), not each at its own.
PLACE = "cx cy cz sx sy sz nx ny nz"
RECTANGLE = np.dtype(
    _floats(FRAME + " sx sy sz half_u half_v inner_u inner_v outward") + _integers("code sheet tie")
)
DISK = np.dtype(_floats(PLACE + " inner2 outer2 breadth least2 most2") + _integers("code sheet tie"))
# c: the first vertex; (a, b) = (p - c) · the dual vectors: weights of the other two vertices in p.
# reach_a, reach_b, reach_c: lengths of the duals of both weights and of the first vertex's; slack: how far it acts beyond its edges.
TRIANGLE = np.dtype(
    _floats(PLACE + " ax ay az bx by bz reach_a reach_b reach_c least_a least_b least_c slack")
    + _integers("code sheet tie")
)
SPHERE = np.dtype(_floats("cx cy cz radius") + _integers("code sheet"))
PLANE = np.dtype(_floats(PLACE) + _integers("code sheet tie"))
PLANES = np.dtype([("one", PLANE), ("other", PLANE)])  # parallel ones
# A rectangle with a hole, its centre at (hole_u, hole_v) from the rectangle's, turned by the cosine and sine of an angle:
# half sides of a rectangle, or half_p a radius where half_q is 0.  margin: that far from its edge a point is on the edge.
HOLED = np.dtype(RECTANGLE.descr + _floats("hole_u hole_v hole_cos hole_sin half_p half_q margin"))
# Surfaces of revolution of the second order (physics/quadrics.py) about the axis a, between two heights.
QUADRIC = np.dtype(
    _floats("cx cy cz ax ay az alpha beta gamma low high inner_low inner_high") + _integers("code sheet")
)
# By sheet, where any is such a surface: is_curved 1, else 0.  narrows: of a cone, along the axis 1, against it -1, else 0.
CURVED_SHEET = np.dtype(_floats("cx cy cz ax ay az alpha beta gamma narrows") + _integers("is_curved"))

# A mesh: its vertices (x, y, z), of each facet the numbers of three and the normal, and a hierarchy of boxes about c.  A node is a
# cache line: the boxes of two children, and of each the first facet and how many, or the child's own node and 0.
MESH = np.dtype(
    _floats("cx cy cz")
    + _integers("vertices vertex_count faces normals facet_count nodes node_count code sheet")
)
NODE = np.dtype(
    [(f"{side}_{x}{n}", "f4") for n in (0, 1) for side in ("low", "high") for x in "xyz"]
    + [(f"{what}{n}", "i4") for n in (0, 1) for what in ("first", "count")]
)
MESHED_SHEET = np.dtype(
    _integers("vertices vertex_count faces normals facet_count")
)  # by sheet, 0 for what is no mesh

SHEET = np.dtype(
    _floats("nx ny nz cx cy cz radius curvature outward")
)  # curvature 1/radius, 0 for a plane; outward: +1 or -1 where a box's normal is that of the sheet or opposite, else 0
# A mixture is as many rows as it has parts, one behind the other; share: of its parts up to and with this one.
# quantiles: address of a QUANTILES row from which speeds are drawn anew, 0: they stay.
# back: rows from there to those of the other side, 0 where both sides are alike.
SURFACE = np.dtype(_floats("albedo share") + _integers("material parts quantiles back"))
# What light needs to know of a surface, by its row.  side: -1 where its normal is opposite to its sheet's;  ratio: index inside over
# outside (0 for what is no boundary of media), excess: (ratio - 1)(ratio + 1);  through: share of what goes on that passes;  power: 1/focal length, of a lens at c.
OPTICS = np.dtype(
    _floats("side inside outside ratio excess roughness through cx cy cz power") + _integers("lobe")
)

# Where a surface ends, by its row: points within rounding of that are drawn back from it (landings.py).
RECTANGLE_RIM, DISK_RIM, TRIANGLE_RIM, QUADRIC_RIM = 1, 2, 3, 4
RIM = np.dtype(
    _floats(FRAME + " inner_u inner_v low high alpha beta gamma ax ay az bx by bz least_a least_b least_c")
    + _floats("hole_u hole_v hole_cos hole_sin half_p half_q margin")
    + _integers("form")
)

# The meter in layer l of a sheet: a look is one int64, 0 for none, so that a lane fetches a single word.
#   bits 0-37 its first row;  38-58 number of its cosine bins;  59 it looks against the sheet's normal;  60 it is there
# mark: the bits that a visit sets, where a detector asks `via`.
# front, back: the bits of bodies that a particle is in which leaves to the front or to the back.
LAYER = np.dtype(_integers("look meter mark front back"))
LOOK_BASE, LOOK_CELLS_SHIFT, LOOK_CELLS, LOOK_BACK, LOOK = (1 << 38) - 1, 38, (1 << 21) - 1, 1 << 59, 1 << 60
LAYERS = np.dtype(
    _integers("rows count layer half meters meter_count")
)  # half: rows from arrivals to departures
# A meter's axes beyond plain cosine bins: kind of coordinate (0: none), number of cells, address of their edges, distance
# in rows from one cell to the next; turn_low: the first azimuth edge [rad].
WORLD_COSINE, LOCAL_COSINE, CONE, FLAT_AZIMUTH, SPHERE_AZIMUTH, WORLD_AZIMUTH = 1, 2, 3, 4, 5, 6
RECTANGLE_PLACE, DISK_PLACE, SPHERE_PLACE, REVOLVED_PLACE = 1, 2, 3, 4


def _axis(name: str) -> list[tuple[str, str]]:
    return _integers(f"{name}_cells {name}_edges {name}_stride")


METER = np.dtype(
    _floats(FRAME + " axis_x axis_y axis_z side handed turn_low strong")
    + _integers("mu_kind turn_kind place via least most outside by_cell of_rays")
    + [column for axis in ("mu", "turn", "u", "v", "time", "speed") for column in _axis(axis)]
)  # axis: of a sphere, or of a cone, whose lower edge is minus the squared sine of its half angle
# via: bits of what must have been visited; least, most: reflections; outside: row outside of all times and speeds
# by_cell: first of its rows by the cell of birth, of a source that is run backwards;  of_rays: that of what rays bring it;
# strong: the least score of a ray that is among the strongest

# A detector that histories start at: its cells from `first` on, of mu, turn, u and v (the shape's own), and what their edges are of:
# squared cosines (and squared sines at sine_edges), cosines to +z, or columns of pixels; turns, or their rows; lengths, squared radii
# or cosines.  births: row of the histories of cell 0;  spread: 1 - cos of a cone about `axis`;  side: of its normal, handed: of e_u.
SENSOR = np.dtype(
    _floats(FRAME + " axis_x axis_y axis_z side handed radius spread")
    + _integers("first cells part births sine_edges")
    + [column for axis in ("mu", "turn", "u", "v") for column in _axis(axis)]
)

# Media by body: row 0 is what surrounds all bodies, row 1 + k the medium of body k.  mfp, sigma_a, survival as in the bundle;
# phase: number of its phase function (the first of a mixture's), from 1.
MEDIA = np.dtype(_floats("mfp sigma_a survival index") + _integers("phase"))
INSIDE = np.dtype(_integers("inside"))  # of a birth: the bits of the bodies that it is in
BESIDE = np.dtype(
    _floats("nx ny nz") + _integers("bit")
)  # of a birth on a body's boundary: its outward normal
BODY_BOX = np.dtype(_floats("cx cy cz hx hy hz") + _integers("bit"))
BOUNDED = np.dtype(
    _floats("low_x low_y low_z high_x high_y high_z") + _integers("bit")
)  # a finite body's bit, 0 for what has no end, and the box about it
BODY = np.dtype(_integers("bit medium") + _floats("mfp sigma_a survival"))  # bit: 0 for what surrounds all
WEIGHED = np.dtype(_integers("medium ledger"))  # a row of MEDIA that absorbs, and that of the ledger
# Importance e^rise, rise = (x - c) · k between 0 and `most`.  has_grids: 1 where what a flight goes through is not told by its free path.
IMPORTANCE = np.dtype(_floats("cx cy cz kx ky kz most") + _integers("has_grids"))
ROULETTE_LAW = np.dtype(
    _floats("threshold level")
)  # shares of the birth weight: below which it is played, and what a survivor has
PHASE_LAW = np.dtype(_floats("g share") + _integers("number parts rows count"))  # of a phase function
# Voxels that fill a body.  c: the lower corner, per: voxels per scene length, n: voxels, m: macro cells of `block` voxels a side along
# each axis; tops: address of their majorants [1/scene lengths], one more on every side;  levels: of each voxel's extinction over the
# majorant in LEVELS steps, rounded down: so a byte decides nearly all of what happens there.  absorption, scattering: addresses of the user's own arrays [m^-1], and the
# steps along each axis in numbers, 0 where one number serves all; length [m] of a scene length.
GRID = np.dtype(
    _floats("cx cy cz per_x per_y per_z length")
    + _integers("medium ledger absorbs block nx ny nz mx my mz tops top_count levels level_count")
    + [
        column
        for name in ("absorption", "scattering")
        for column in _integers(f"{name} {name}_count {name}_x {name}_y {name}_z")
    ]
)
LEVELS = 255.0
SLACK = 2.0**-48  # [scene lengths] by which collisions keep clear of what is ahead and behind

# A volume detector: a box of half sides h, or a ball of radius hx with the radii of its shells.  scale: one over the largest score of
# weight 1 [1/scene lengths];  first: its first row;  rows: of a cell, the outside of all bins of direction and those;  kept: first row of
# what its cells absorb, 0 where nothing does;  is_one: there is but one cell;  is_even: all bins of direction are equal;  per: cells per scene length.
VOLUME = np.dtype(
    _floats(FRAME + " hx hy hz width_x width_y width_z per_x per_y per_z scale turn_low")
    + _integers("first rows kept is_one is_even cells_x cells_y cells_z radii")
    + [column for axis in ("mu", "turn") for column in _axis(axis)]
)

# fades: 1 where weights are lessened on the way
VOLUME_IN_GRID = np.dtype([("volume", VOLUME), ("grid", GRID), ("fades", "i8")])

# A point detector: where it is, the first of its POINT_ROWS rows of sums (compile/points.py), its number among their draws.
# medium: the row of MEDIA about it, where that scatters: there rays are scattered once more; else -1.
POINT = np.dtype(_floats("x y z") + _integers("first number medium"))
# What each birth sends there: intensity in all directions alike, and along the normal of a diffuse emitter, over the weight [sr^-1].
POINT_EMISSION = np.dtype(_floats("x y z isotropic lambertian") + _integers("first number"))
# A box of half sides h, or a ball of radius hx, about c that emits uniformly; scale: one over its volume.
POINT_GLOW = np.dtype(_floats("x y z cx cy cz hx hy hz scale") + _integers("first number"))
# A phase function, or part of a mixture that begins with `number`, as a density per steradian.
POINT_PHASE = np.dtype(_floats("g share") + _integers("number cosines values cells"))
# Row POINT_MIDDLE + k of a point detector holds scores from 2^(4 k) up to 2^(4 k + 4), down to the least normal numbers.
POINT_ROWS, POINT_MIDDLE, POINT_OCTAVES = 320, 256, 4
# A detector whose crossings are expected: its shape about c (n: its normal; half_w: a ball's radius), its area;  sharing: above 0 where
# what arrives close by is left to flights (engine/expecting.py);  scale: a power of two by which its scores are made large;
# peak: the greatest density of a direction after events of this kind [sr^-1], isotropic and lambertian: of births;  first: where its
# expected rows begin, number: its own among their draws, sheet: a flat one's, from which it is not seen;  legs: crossings of one ray.
EXPECTATION = np.dtype(
    _floats(
        FRAME
        + " half_u half_v half_w inner2 outer2 ax ay az bx by bz area peak sharing scale isotropic lambertian"
    )
    + _integers("first number sheet legs")
)
# What of a meter's crossings by flights rays have told.  how: 1 all, else all but the share peak area/(r^2 + peak area), r
# from the event to the crossing (2) or to the centre of a ball (3);  passing: 1 where what acts counts as it comes.
HELD = np.dtype(_floats("cx cy cz area") + _integers("how sheet passing"))
TOLD = np.dtype(_floats("peak"))
GUARD = np.dtype(
    _floats("cx cy cz radius2") + _integers("first cells")
)  # a ball; first: its cell of sheet 0 among `cells`
WORD = np.dtype(
    _integers("source target")
)  # of two bundles: a word of the one is moved into a word of the other; -1: 0

# How often scores of each size come (compile/sizes.py): cells of a detector's side, SIZE_PARTS an octave from 2^SIZE_OCTAVE on.
# numbers: by row of a meter, where its cells begin;  cells: how many there are in all;  resting: bits of a batch's number,
# of which one that is set tells that the batch counts no sizes.
SIZE_CELLS, SIZE_PARTS, SIZE_OCTAVE = 224, 4, -50
SIZES = np.dtype(_integers("numbers count cells resting"))

CONTACT = np.dtype(
    _floats("cx cy cz nx ny nz alpha beta gamma reach") + _integers("surface sheet is_plane")
)  # n: the normal of a plane, the axis of a surface of revolution

CLOCK = np.dtype(_floats("duration slowness"))  # slowness: 1/speed, where all fly alike
MEDIA_CLOCK = np.dtype(_floats("slowness") + _integers("rows count has_speeds"))
MOMENTS = np.dtype(_floats("fastest slowest") + _integers("is_light"))  # the extreme speeds of the scene

# Speeds by an inverse CDF (quantiles.py): octave k of the lower or upper tail has 2^level cells of CELL_TERMS coefficients each.
QUANTILES = np.dtype(_integers("octaves octave_count cells cell_count"))
OCTAVE = np.dtype(_integers("cells"))  # its first cell, and the level from bit 32 on
CELL_TERMS, OCTAVES = 8, 54  # a cache line a cell: coefficients, then the split; octaves of each tail

# Phase space at a time: up to two coordinates of those below, in bins; first: its row for the outside, the bins follow.
COORDINATES = ("x", "y", "z", "vx", "vy", "vz", "speed", "mu")  # numbered from 1
PHASE = np.dtype(
    _floats("time low_x low_y low_z high_x high_y high_z fastest vx vy vz")
    + _integers("first moments")
    + [column for axis in ("a", "b") for column in (*_integers(f"{axis}_kind"), *_axis(axis))]
)  # moments: first row of its velocity sums, -1: none
# moments: first row of the velocity sums, -1: none;  vx, vy, vz: the velocity about which they are taken, in which
# all sums but that of the speed stay free of cancellation.
VELOCITY_SUMS = ("vx", "vy", "vz", "vx2", "vy2", "vz2", "speed")
SNAPSHOT = np.dtype(_floats("time") + _integers("number"))
RECORD = np.dtype(_floats("x y z vx vy vz weight") + _integers("history batch snapshot"))

# Ways written down for a picture: from x + start u to x + reach u, infinite where nothing is ahead.  met: whether they end at
# a surface that acts, and not at a meter, a collision or the end of the clock.
WAY = np.dtype(_floats("x y z ux uy uz start reach weight") + _integers("history met"))

# Births.  An emitter lies on a sheet (0: none) and emits from the side where side = +1 or -1 times its normal points.
BIRTH = np.dtype(_floats("weight start") + _integers("sheet"))
MEDIUM = np.dtype(_floats("index"))  # 0 where it is not known
MOMENT = np.dtype(_floats("start width"))  # of birth [durations]
VELOCITY = np.dtype(_floats("vx vy vz"))  # of a drift, or the first alone: a speed
PATCH = np.dtype(_floats(FRAME + " half_u half_v half_w inner2 outer2 side"))
BAND = np.dtype(
    _floats(FRAME + " alpha beta gamma low high first last side")
)  # first, last: what the area per height is proportional to at both ends, linear between them
AREAS = np.dtype(
    _floats("side") + _integers("vertices vertex_count faces normals facet_count shares")
)  # shares: of the area up to and with a facet
DRIFTING = np.dtype(
    _floats(FRAME + " side sigma drift_u drift_v") + _integers("octaves octave_count cells cell_count")
)
BEAM = np.dtype(_floats("ux uy uz"))
TARGET = np.dtype(
    _floats(FRAME + " half_u half_v half_w inner2 outer2 ax ay az bx by bz")
    + _floats("area isotropic lambertian natural unit")
)  # unit: one over the largest weight


def row(kind: np.dtype, **values: float) -> np.ndarray:
    """A table row of that kind; columns not named are 0."""
    record = np.zeros((), kind)
    for name, value in values.items():
        record[name] = value
    return record


def center_columns(point: tuple[float, float, float]) -> dict[str, float]:
    """A point as columns of a table."""
    return dict(zip(("cx", "cy", "cz"), point, strict=True))


def frame_columns(frame: tuple[tuple[float, ...], ...]) -> dict[str, float]:
    """A local frame (e_u, e_v, n) as columns of a table."""
    return {
        f"{e}{x}": value
        for e, v in zip(("eu", "ev", "n"), frame, strict=True)
        for x, value in zip("xyz", v, strict=True)
    }
