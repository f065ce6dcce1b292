"""Memory layout of a plan: record types of the passes' tables, and the parts of a lane's words.

A lane's next hit is two words. `hit` holds the sheet, the row of the acting surface and its material, which
passes read and write as `lane.hit_sheet`, `lane.surface` and `lane.material`; 0 is no hit. `covered` says
what covers the point: a bit per detector or boundary of a medium on the sheet (bit l: layer l), and EDGE,
EMPTY_FRONT and EMPTY_BACK.
"""

from collections.abc import Iterable

import numpy as np

from transport.scene.materials import OPTICAL_COLUMNS

DETECTORS_PER_SHEET = 60
# Nothing lies in front of the sheet, or behind it; the point lies within rounding of its shape's edge.
EMPTY_FRONT, EMPTY_BACK, EDGE = 1 << 60, 1 << 61, 1 << 62
TAKEN = EDGE  # at a birth, where no edge matters: a surface acts there, and those after it do not
# parts of a lane's words by name: word, first bit, number of bits
PARTS = {"hit_sheet": ("hit", 0, 24), "surface": ("hit", 24, 24), "material": ("hit", 48, 15)}
MAX_SHEETS = MAX_SURFACES = (1 << 24) - 1


def hit_word(sheet: int, surface: int = 0, material: int = 0) -> int:
    """Return the word of a hit."""
    return sheet | surface << PARTS["surface"][1] | material << PARTS["material"][1]


def surface_of_hit(word: int) -> int:
    """Return the row of the acting surface in the word of a hit; 0: none."""
    _, shift, bits = PARTS["surface"]
    return int(word) >> shift & (1 << bits) - 1


# codes of a surface's material: how a direction is sampled
INTERACTIONS = "transparent", "black", "diffuse", "mirror", "dielectric", "glossy", "lens"
TRANSPARENT, BLACK, DIFFUSE, MIRROR, DIELECTRIC, GLOSSY, LENS = range(len(INTERACTIONS))

# upper bound of the relative rounding of a crossing's position: four units in the last place
ROUNDING = 2.0**-50

# Below this cosine a crossing scores 2/GRAZING_CUT instead of 1/|mu| in the fluence rate.
GRAZING_CUT = 1e-3

# Scores into few rows wait for one another: lane k adds to copy k % SCORE_COPIES of the rows (driver.Sums).
SCORE_COPIES, MAX_COPIED_ROWS = 4, 256

# bits of a row's number of scores; the grazing scores are counted above them (engine/tally.py)
COUNT_BITS = 36

# The ledger's rows have four words: high, low, number (where counted), and a spare one.
# The spare word of LOST counts refractions from a medium that the scene contradicts, that of ESCAPED counts
# crossings of boundaries from such bodies; that of BORN holds the bits of the heaviest aimed birth weight.
# Absorbed weight follows from ABSORBED on: a row per surface, then a row per row of MEDIA.
BORN, ESCAPED, IN_FLIGHT, ROULETTE, LOST, ABSORBED = 0, 1, 2, 3, 4, 5

# The word of a lane's standing point: the sheet on which its ray began, the sheet of the last detector that
# it crossed there (0: none), and whether it left a box.
STANDING_SHEET_MASK, LEFT_BOX, PASSED_SHIFT = (1 << 24) - 1, 1 << 24, 32

NO_TABLE = np.dtype([("unused", "f8")])
# Rows name arrays by their offsets [bytes] in the arena of the plan (compile/arena.py); 0: none.
# Offset and length of an array of one of the row types below.
ROWS = np.dtype([("rows", "i8"), ("count", "i8")])
# Offsets and lengths of two such arrays.
TWO_ROWS = np.dtype([("rows", "i8"), ("count", "i8"), ("others", "i8"), ("other_count", "i8")])
FIELD_MOVES = np.dtype([("fields", "i8"), ("count", "i8")])  # offset and number of the fields to move
# Fields that a lane takes along to the queue at surfaces, and those that a lane in flight takes to a gap.
QUEUE = np.dtype([("arriving", FIELD_MOVES), ("flying", FIELD_MOVES)])
BITS = np.dtype([("bits", "i8")])  # of `covered`
LEDGER_ROW = np.dtype([("ledger", "i8")])
LEG = np.dtype([("leg", "i8")])  # of a shadow ray
# Marks of a shadow ray: crossings of its detector that are left, or of a ray to a point STRAIGHT_LEG, and
# FIRST_LEG minus the point's number where a second leg follows.
STRAIGHT_LEG, FIRST_LEG = -1, -2


def _floats(names: str) -> list[tuple[str, str]]:
    """Return float64 columns of these names, separated by spaces."""
    return [(name, "f8") for name in names.split()]


def _integers(names: str) -> list[tuple[str, str]]:
    """Return int64 columns of these names, separated by spaces."""
    return [(name, "i8") for name in names.split()]


# All lengths are in scene lengths. e_u, e_v, n: the local frame of FlatShape.frame (geometry/flat.py).
FRAME = "cx cy cz eux euy euz evx evy evz nx ny nz"

# s: a point of the sheet. All detectors of a sheet are intersected with the plane through s with normal n,
# not each with its own plane.
PLACE = "cx cy cz sx sy sz nx ny nz"
# side: of the normal on which it acts, 0 for both, where several share a plane (passes/shared_planes.py).
# half_next, half_last: half sides along the two axes after that of the normal (x, y, z, x ...), where the
# rectangle is aligned with the axes.
RECTANGLE = np.dtype(
    _floats(FRAME + " sx sy sz half_u half_v inner_u inner_v outward side")
    + _floats("half_next half_last inner_next inner_last")
    + _integers("hit covers sheet tie")
)
DISK = np.dtype(
    _floats(PLACE + " inner2 outer2 breadth least2 most2 side") + _integers("hit covers sheet tie")
)
# c: the first vertex; (a, b) = (p - c) · dual vectors: weights of the other two vertices at point p.
# reach_a, reach_b, reach_c: lengths of the duals of both weights and of the first vertex's weight.
# slack: distance by which an acting triangle reaches over its edges.
TRIANGLE = np.dtype(
    _floats(PLACE + " ax ay az bx by bz reach_a reach_b reach_c least_a least_b least_c slack side")
    + _integers("hit covers sheet tie")
)
SPHERE = np.dtype(_floats("cx cy cz radius") + _integers("hit covers sheet"))
PLANE = np.dtype(_floats(PLACE + " side") + _integers("hit covers sheet tie"))
PLANES = np.dtype([("one", PLANE), ("other", PLANE)])  # two parallel planes
# A rectangle with a hole. (hole_u, hole_v): center of the hole from that of the rectangle; hole_cos,
# hole_sin: the hole's rotation.
# half_p, half_q: half sides of a rectangular hole; half_p is the radius of a round hole where half_q is 0.
# margin: a point nearer to the hole's edge counts as on the edge.
HOLED = np.dtype(RECTANGLE.descr + _floats("hole_u hole_v hole_cos hole_sin half_p half_q margin"))
# Surfaces of revolution of the second order (physics/quadrics.py) about the axis a, between two heights.
QUADRIC = np.dtype(
    _floats("cx cy cz ax ay az alpha beta gamma low high inner_low inner_high")
    + _integers("hit covers sheet")
)
# Quadrics by sheet: is_curved is 1 for a quadric, else 0. narrows: for a cone +1 or -1 (it narrows along the
# axis or against it), else 0.
CURVED_SHEET = np.dtype(_floats("cx cy cz ax ay az alpha beta gamma narrows") + _integers("is_curved"))

# A mesh: vertices (x, y, z), three vertex numbers and the normal per facet, and a bounding volume hierarchy
# about c. leaves: the facets once more, leaf by leaf: FACET_TERMS runs of as many numbers as the leaf has
# facets, x, y and z of the three vertices and of the normal.
# A node has the boxes of its children (low x, y, z, then high; NaN for none), and per child a word: number of
# facets in the lowest LEAF_BITS bits, above it the first of them, or the child's node where the number is 0.
# A mesh of at most MAX_LEAF_FACETS facets is a single leaf.
FACET_TERMS, CHILDREN, LEAF_BITS, MAX_LEAF_FACETS = 12, 8, 8, 32
VECTOR = 4  # facets that are tested at once; the last leaf is padded by so many numbers
# margin: edge function, twice the area of an edge and a ray's origin as seen along the ray, of a ray that
# passes an edge within rounding [square scene lengths].
MESH = np.dtype(
    _floats("cx cy cz margin")
    + _integers("vertices vertex_count faces normals facet_count leaves nodes node_count hit covers sheet")
)
NODE = np.dtype([("boxes", "f4", (6, CHILDREN)), ("children", "i8", (CHILDREN,))])
# Meshes by sheet; 0 for other sheets.
MESHED_SHEET = np.dtype(_integers("vertices vertex_count faces normals facet_count"))

# Planes and spheres by sheet. curvature: 1/radius, 0 for a plane.
# outward: +1 (-1) where the outward normal of a box is along (against) the sheet's normal, else 0.
SHEET = np.dtype(_floats("nx ny nz cx cy cz radius curvature outward"))
# A mixture has one row per part, in succession; share: cumulative share up to and including this part.
# quantiles: offset of a QUANTILES row for new speeds; 0: speeds do not change.
# back: number of rows to the first row of the back side; 0 where both sides are alike.
SURFACE = np.dtype(_floats("albedo share") + _integers("material parts quantiles back"))
# Optical properties by row of a surface. side: -1 where its normal is opposite to its sheet's normal.
# power: 1/focal length of a lens with center c; the other columns are those of the material's own row.
# lobe: offset of a QUANTILES row for the cosine in the multiple-scattering lobe of microfacets; lobe_peak:
# largest pdf of that lobe [sr^-1], 0 where no ray is sent from microfacets.
OPTICS = np.dtype(_floats("side cx cy cz power lobe_peak " + " ".join(OPTICAL_COLUMNS)) + _integers("lobe"))

# Edges by row of a surface: points within rounding of an edge are clamped inside it
# (engine/passes/landing.py).
RECTANGLE_RIM, DISK_RIM, TRIANGLE_RIM, QUADRIC_RIM = 1, 2, 3, 4
RIM = np.dtype(
    _floats(FRAME + " inner_u inner_v low high alpha beta gamma ax ay az bx by bz least_a least_b least_c")
    + _floats("hole_u hole_v hole_cos hole_sin half_p half_q margin")
    + _integers("form")
)

# The detector in layer l of a sheet. `detector_word` is one int64, 0 for none, so that a lane fetches a
# single word:
#   bits 0-37 first row; 38-58 number of cosine bins; 59 measures against the sheet's normal; 60 present
# mark: bits that a visit sets, where a detector has `via`.
# front, back: bits of the bodies that contain a particle leaving to the front or to the back.
LAYER = np.dtype(_integers("detector_word detector mark front back"))
DETECTOR_BASE_MASK, DETECTOR_CELLS_SHIFT, DETECTOR_CELLS_MASK, DETECTOR_BACK, DETECTOR_PRESENT = (
    (1 << 38) - 1,
    38,
    (1 << 21) - 1,
    1 << 59,
    1 << 60,
)
# half: number of rows from arrivals to departures.
LAYERS = np.dtype(_integers("rows count layer half detectors detector_count"))
# A detector's axes beyond plain cosine bins: kind of coordinate (0: none), number of cells, offset of the
# edges, stride in rows.
# turn_low: the first azimuth edge [rad].
WORLD_COSINE, LOCAL_COSINE, CONE, FLAT_AZIMUTH, SPHERE_AZIMUTH, WORLD_AZIMUTH = 1, 2, 3, 4, 5, 6
RECTANGLE_PLACE, DISK_PLACE, SPHERE_PLACE, REVOLVED_PLACE = 1, 2, 3, 4


def _axis(name: str) -> list[tuple[str, str]]:
    return _integers(f"{name}_cells {name}_edges {name}_stride")


# axis: of a sphere, or of a cone, whose lower edge is minus the squared sine of its half angle.
# via: bits of the visits required; least, most: number of reflections; outside: row for all other times and
# speeds.
# by_cell: first row of sums by cell of birth, for a source of the estimator "backward"; of_rays: the same for
# shadow rays; strong: the least score of a ray that counts as strong; lamp_density: of histories that start
# at this source (compile/caustics.py).
DETECTOR = np.dtype(
    _floats(FRAME + " axis_x axis_y axis_z side handed turn_low strong lamp_density")
    + _integers("mu_kind turn_kind place via least most outside by_cell of_rays")
    + [column for axis in ("mu", "turn", "u", "v", "time", "speed") for column in _axis(axis)]
)

# A detector from which particles start (estimator "backward"). Its cells, of mu, turn, u and v (the shape's
# own), are numbered from `first` on.
# mu_edges: squared cosines (with squared sines at sine_edges), cosines to +z, or columns of pixels.
# turn_edges: turns, or rows of pixels. u_edges, v_edges: lengths, squared radii or cosines.
# births: row of the births in cell 0; spread: 1 - cos of the half angle of a cone about `axis`; side: of its
# normal; handed: sign of e_u; nearness, power: one over the distance in focus, and over the focal length;
# rim: radius of the image of all directions.
SENSOR = np.dtype(
    _floats(FRAME + " axis_x axis_y axis_z side handed radius spread nearness power rim")
    + _integers("first cells part births sine_edges")
    + [column for axis in ("mu", "turn", "u", "v") for column in _axis(axis)]
)

# First interaction of a history (field `began`) where some start at lamps (compile/caustics.py): none yet, at
# a diffuse wall, or another. Below 0: none yet of a history from a lamp, which must be at the surface of this
# number, counted from -1 downwards.
UNBEGUN, DIFFUSE_FIRST, OTHER_FIRST = 0, 1, 2
BEGINNING = np.dtype(_floats("density") + _integers("cell began"))  # state of such histories at birth
# A Camera or an EnvironmentMap that rays end at. first: first row of its sums for the first lamp; cells:
# number of rows per lamp; projection: what its cells are; scale: of the density of its histories.
BINS_SEEN, PINHOLE_SEEN, CUBE_SEEN, FISHEYE_SEEN, EQUAL_AREA_SEEN = range(5)
VIEW = np.dtype([("sensor", SENSOR), *_floats("scale"), *_integers("first cells projection")])

# Media by body: row 0 is the surrounding medium, row 1 + k the medium of body k. mfp, sigma_a, survival: as
# in the bundle.
# phase: number of its phase function, from 1 (the first part of a mixture); 0: none.
MEDIA = np.dtype(_floats("mfp sigma_a survival index") + _integers("phase"))
BIRTH_BODIES = np.dtype(_integers("inside"))  # bits of the bodies that a birth lies in
# A birth on the boundary of a body: the outward normal and the body's bit.
BIRTH_BOUNDARY = np.dtype(_floats("nx ny nz") + _integers("bit"))
BODY_BOX = np.dtype(_floats("cx cy cz hx hy hz") + _integers("bit"))
# A body's bounding box with its bit; bit 0 for unbounded bodies.
BODY_BOUNDS = np.dtype(_floats("low_x low_y low_z high_x high_y high_z") + _integers("bit"))
# bit: 0 for the surrounding medium
BODY = np.dtype(_integers("bit medium") + _floats("mfp sigma_a survival"))
# A row of MEDIA that absorbs, and its row of the ledger.
ABSORBING_MEDIUM = np.dtype(_integers("medium ledger"))
# Importance is e^rise with rise = (x - c) · k, clipped to [0, most]. has_grids: 1 where the free path alone
# does not describe the medium.
IMPORTANCE = np.dtype(_floats("cx cy cz kx ky kz most") + _integers("has_grids"))
# threshold: share of the birth weight below which Russian roulette is played; level: a survivor's share.
ROULETTE_LAW = np.dtype(_floats("threshold level"))
# A phase function, or one part of a mixture. g: the parameter of its law, the mean cosine for most.
PHASE_LAW = np.dtype(_floats("g share") + _integers("number parts rows count"))
# Voxels that fill a body. c: lower corner; per: voxels per scene length; n: voxels; m: macro cells of `block`
# voxels per side, each by axis.
# tops: offset of the majorants [1/scene lengths], with one extra cell on every side.
# levels: each voxel's extinction over its majorant in LEVELS steps, rounded down: one byte decides nearly all
# collisions.
# absorption, scattering: offsets of the coefficients [m^-1], with a stride (0 where one number serves
# all); length: [m] per scene length.
GRID = np.dtype(
    _floats("cx cy cz per_x per_y per_z length")
    + _integers("medium ledger absorbs block nx ny nz mx my mz tops top_count levels level_count")
    + _integers("absorption absorption_count absorption_stride scattering scattering_count scattering_stride")
)
LEVELS = 255.0
# [scene lengths] distance that collisions keep from the surfaces ahead and behind
COLLISION_CLEARANCE = 2.0**-48

# A volume detector: a box of half sides h, or a sphere of radius hx with the radii of its shells, or a
# cylinder about the axis a, of radius hx and half height hz, with the radii of its rings.
# scale: 1 over the largest score of weight 1 [1/scene lengths]; per: cells per scene length.
# first: its first row; rows: per cell, one outside all direction bins, then the bins; kept: first row of
# absorbed weight by cell, 0 without absorption.
# is_one: there is one cell only; is_even: all direction bins are equal.
VOLUME = np.dtype(
    _floats(FRAME + " ax ay az hx hy hz width_x width_y width_z per_x per_y per_z scale turn_low")
    + _integers("first rows kept is_one is_even cells_x cells_y cells_z radii")
    + [column for axis in ("mu", "turn") for column in _axis(axis)]
)

# fades: 1 where absorption reduces weights along the path.
VOLUME_IN_GRID = np.dtype([("volume", VOLUME), ("grid", GRID), ("fades", "i8")])

# A point detector: its position, and its number in the random number counter.
# medium: row of MEDIA around it, where that scatters: rays there are scattered once more (once-more-collided
# estimator); else -1.
POINT = np.dtype(_floats("x y z") + _integers("number medium"))
# A box of half sides h, or a sphere of radius hx, about c that emits uniformly; scale: 1 over its volume.
POINT_GLOW = np.dtype(_floats("x y z cx cy cz hx hy hz scale") + _integers("number"))
# A part of a Beam's shape (its columns), which emits in direction u. slack: distance by which rounding of
# coordinates can move the end of a ray there.
BEAM_PART = np.dtype(_floats(FRAME + " half_u half_v inner2 outer2 ax ay az bx by bz ux uy uz slack"))
# A source that shadow rays end at in a backward run. first: its row of sums in cell 0; strong: the least
# score that counts as strong.
RAY_LAMP = np.dtype(_floats("strong") + _integers("first"))
# Density per steradian of a phase function, or of one part of a mixture that begins with `number`.
POINT_PHASE = np.dtype(_floats("g share") + _integers("number cosines values cells"))
# Row POINT_MIDDLE + k of a point detector holds scores from 2^(4 k) up to 2^(4 k + 4), down to the smallest
# normal numbers.
POINT_ROWS, POINT_MIDDLE, POINT_OCTAVES = 320, 256, 4
# A detector whose crossings are expected (next-event estimation): its shape about c (n: normal; half_w:
# radius of a sphere) and its area.
# sharing: above 0 where close events share their contribution with the particle's own crossing (MIS,
# engine/passes/next_event.py).
# number: its own in the random number counter; sheet: of a flat detector, whose own events send no rays to
# it; parts: offset of a polygon's triangles, ten numbers each (cumulative share of the area, corner, two
# edges).
EXPECTATION = np.dtype(
    _floats(FRAME + " half_u half_v half_w inner2 outer2 ax ay az bx by bz area sharing")
    + _integers("number sheet parts part_count")
)
# What events contribute to a detector. isotropic, lambertian: density of directions at birth [sr^-1], the
# latter along the normal; scale: power of two by which its scores are multiplied; first: first row of its
# sums.
CONTRIBUTION = np.dtype(_floats("isotropic lambertian scale") + _integers("first"))
# Share of a detector's crossings that shadow rays have already scored. how: 1 all; else all but the share
# peak area/(r^2 + peak area).
# r: distance from the event to the crossing (how 2) or to the center of a sphere (how 3); passing: 1 where an
# acting surface scores on arrival.
MIS_SHARE = np.dtype(_floats("cx cy cz area") + _integers("how sheet passing"))
MIS_PEAK = np.dtype(_floats("peak"))
# The same where shadow rays pass surfaces and are reflected. transmits: whether some surface transmits.
MIS_LINK = np.dtype(_floats("peak") + _integers("transmits"))
# What a shadow ray keeps at an acting surface, by row of SURFACE, from its front and its back: reflected by a
# mirror, and straight on. side: -1 where its normal is opposite to its sheet's normal; mirror: its number.
LINK = np.dtype(_floats("front_reflects front_passes back_reflects back_passes side") + _integers("mirror"))
# Above the first row of its detector a shadow ray has the numbers of the mirrors that it has yet to meet, the
# next one lowest.
MIRROR_SHIFT, MIRROR_BITS = 40, 7
# A sphere; first: its cell of sheet 0 among `cells`.
GUARD = np.dtype(_floats("cx cy cz radius2") + _integers("first cells"))
# Word `source` of one bundle is copied into word `target` of another.
WORD = np.dtype(_integers("source target"))

# Histogram of scores by size (compile/detectors.py): per side of a detector SIZE_CELLS cells, SIZE_PARTS per
# octave from 2^SIZE_OCTAVE on.
# numbers: by row of a detector, where its cells begin; cells: number of all cells.
# resting: a mask of the batch's number; a batch with any of these bits set does not count sizes.
SIZE_CELLS, SIZE_PARTS, SIZE_OCTAVE = 224, 4, -50
SIZES = np.dtype(_integers("numbers count cells resting"))

# n: normal of a plane, axis of a surface of revolution.
CONTACT = np.dtype(_floats("cx cy cz nx ny nz alpha beta gamma reach") + _integers("surface sheet is_plane"))

CLOCK = np.dtype(_floats("duration slowness"))  # slowness: 1/speed, where all particles have one speed
MEDIA_CLOCK = np.dtype(_floats("slowness") + _integers("rows count has_speeds"))
# Velocity sums of detectors: extreme speeds of the scene, and their place among the long sums of a row
# (compile.detectors.LongScore).
MOMENTS = np.dtype(_floats("fastest slowest") + _integers("is_light place each"))

# Speeds by an inverse CDF (quantiles.py): octave k of the lower or upper tail has 2^level cells of CELL_TERMS
# coefficients each.
QUANTILES = np.dtype(_integers("octaves octave_count cells cell_count"))
OCTAVE = np.dtype(_integers("cells"))  # first cell, and the level from bit 32 on
# One cache line per cell: coefficients, then the split. OCTAVES: octaves of each tail.
CELL_TERMS, OCTAVES = 8, 54

# Phase space at one time, in bins of up to two coordinates, numbered from 1 as in scene/phase_space.py.
# first: row outside all bins; the bins follow.
# moments: first row of the velocity sums, -1: none.
# vx, vy, vz: the velocity about which moments are taken, so that all sums but that of the speed are free of
# cancellation.
PHASE = np.dtype(
    _floats("time low_x low_y low_z high_x high_y high_z fastest vx vy vz")
    + _integers("first moments")
    + [column for axis in ("a", "b") for column in (*_integers(f"{axis}_kind"), *_axis(axis))]
)
VELOCITY_SUMS = ("vx", "vy", "vz", "vx2", "vy2", "vz2", "speed")
SNAPSHOT = np.dtype(_floats("time") + _integers("number"))
RECORD = np.dtype(_floats("x y z vx vy vz weight") + _integers("history batch snapshot"))

# A recorded path segment: from x + start u to x + reach u, infinite where it escapes.
# met: 1 where it ends at an acting surface, 0 at a detector, a collision or the end of the clock.
PATH_SEGMENT = np.dtype(_floats("x y z ux uy uz start reach weight") + _integers("history met"))

# Births. An emitter lies on a sheet (0: none) and emits from the side to which `side` (+1 or -1) times its
# normal points.
BIRTH = np.dtype(_floats("weight start") + _integers("sheet"))
# A learnt density of births: boxes of the four uniform numbers of a birth (compile/guides.py).
# shares: cumulative probabilities; boxes: GUIDE_BOX_WORDS numbers each; origin: number of the emitter.
GUIDE = np.dtype(_integers("shares boxes count origin"))
GUIDE_BOX_WORDS = 9  # low end and width of each number, and the birth weight
# What a history was born from: its numbers, its birth weight and its emitter.
BIRTH_RECORD = np.dtype(_floats("u0 u1 u2 u3 worth") + _integers("origin"))
# Where a history's scores are added up: by row of a detector's side, a factor, and the number of the sum
# among `count` sums of the history.
HISTORY_SUMS = np.dtype(_integers("factors numbers rows count"))
MEDIUM = np.dtype(_floats("index"))  # 0 where unknown
BIRTH_TIME = np.dtype(_floats("start width"))  # time of birth [durations]
VELOCITY = np.dtype(_floats("vx vy vz"))  # a drift velocity; or vx alone: a speed
PATCH = np.dtype(_floats(FRAME + " half_u half_v half_w inner2 outer2 side"))
# first, last: relative area per height at both ends, linear between them.
BAND = np.dtype(_floats(FRAME + " alpha beta gamma low high first last side"))
# shares: cumulative share of the area per facet.
FACET_AREAS = np.dtype(_floats("side") + _integers("vertices vertex_count faces normals facet_count shares"))
DRIFTING_GAS = np.dtype(
    _floats(FRAME + " side sigma drift_u drift_v") + _integers("octaves octave_count cells cell_count")
)
BEAM = np.dtype(_floats("ux uy uz"))
# unit: 1 over the largest weight.
TARGET = np.dtype(
    _floats(FRAME + " half_u half_v half_w inner2 outer2 ax ay az bx by bz")
    + _floats("area isotropic lambertian natural unit")
)


def row(kind: np.dtype, columns: dict[str, float] | None = None, **values: float) -> np.ndarray:
    """Return a table row of that kind; columns that are not named are 0.

    columns: a description, such as that of a shape, of which the row takes the columns that it has.
    """
    record = np.zeros((), kind)
    for name in kind.names if columns is not None else ():
        record[name] = columns.get(name, 0)
    for name, value in values.items():
        record[name] = value
    return record


def vector_columns(name: str, vector: Iterable[float]) -> dict[str, float]:
    """Return a vector as columns: a name followed by x, y and z."""
    return {f"{name}{x}": value for x, value in zip("xyz", vector, strict=True)}


def center_columns(point: tuple[float, float, float]) -> dict[str, float]:
    """Return a point as the columns cx, cy, cz."""
    return vector_columns("c", point)


def frame_columns(frame: tuple[tuple[float, ...], ...]) -> dict[str, float]:
    """Return a local frame (e_u, e_v, n) as columns."""
    e_u, e_v, normal = frame
    return vector_columns("eu", e_u) | vector_columns("ev", e_v) | vector_columns("n", normal)
