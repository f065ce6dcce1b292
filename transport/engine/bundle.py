"""A bundle: a few hundred particles (lanes) as one record, one fixed-length array a field.

All fields hang on one base address at offsets known when compiling, so LLVM sees that they do not overlap and
vectorises the lane loops.  A field that no pass of a program names is never touched, and so never in cache.
"""

import os

import numpy as np

LANES = int(
    os.environ.get("TRANSPORT_LANES", "256")
)  # a constant of the build; the variable is a seam for tests
# words from field to field: a cache line more, lest one lane's fields all compete for one cache set
PITCH = LANES + 8

HEADER = (
    "address",  # of this record: lanes are moved as rows of int64
    "tallies",  # address of the batch's detector sums
    "sizes",  # address of its counts of scores by size
    "moments",  # address of its rows of four limbs: sums of velocities
    "records",  # address of the sample taken at snapshots ...
    "recorded",  # ... how many there are ...
    "stride",  # ... of how many histories one is taken ...
    "phase",  # ... and with which of them it begins
    "ways",  # address of the ways written down for a picture ...
    "ways_room",  # ... how many there may be ...
    "walked",  # ... and how many there were
    "ledger",  # address of the batch's ledger sums
    "ledger_words",
    "seed_low",
    "seed_high",
    "batch",
    "next_history",  # number of the history that the next newborn lane begins
    "worth",  # bits of the weight that newborns have, of those at which all that an emitter sends is dealt to its histories
    "started",  # histories born so far; other threads may read it while the bundle runs
    "crossings",
    "collisions",
    "first",  # the first of the lanes that met a surface (lanes.part); 0 where all do
    "bank",  # address of the copies that wait for a lane ...
    "banked",  # ... how many there are ...
    "bank_room",  # ... how many there may be ...
    "overfull",  # ... 1 where there were more, or how many were made in all where these are too many
    "colliding",  # lanes that fly on in a medium, of those that flew last
    "grazes",  # 1 where a meter was crossed beyond the grazing cut in the last pass that looked, else 0
    "scored",  # what volume detectors have added up: a bound of their sums (driver.MOST_SCORED)
    "shadow",  # address of the bundle of shadow rays, where there are point detectors ...
    "cast",  # ... how many of them lanes cast in the last pass ...
    "taken",  # ... and how many of these are under way
    "given_up",  # histories of too many events (surfaces.give_up)
    "patience",  # crossings in which some history must end, or some weight be lost (driver.PATIENCE) ...
    "patience_in_media",  # ... and collisions
    "trapped",  # lanes of which none has ended or lost weight for so long, else 0
    "stop",  # set by another thread: end before the batch is complete
)
HEADER_WORDS = -(-len(HEADER) // 8) * 8  # whole cache lines, so that every field of lanes begins on one

# What a particle takes along: a program moves just the fields that its passes name.
CARRIED = (
    ("x", "f8"),  # position [scene lengths]
    ("y", "f8"),
    ("z", "f8"),
    ("ux", "f8"),  # direction
    ("uy", "f8"),
    ("uz", "f8"),
    ("weight", "f8"),  # [largest birth weight of the scene]
    ("birth", "f8"),  # weight when born
    ("history", "i8"),  # number within the batch
    ("event", "i8"),  # reflections so far, and other crossings that drew: numbers the draws
    ("sheet", "i8"),  # the support that it stands on, and the meter's that it passed last (layout.STANDING)
    ("start", "f8"),  # where on the ray it is: 0, or negative for one aimed at a target where x is
    ("distance", "f8"),  # along the ray from x to what it meets next
    ("hit", "i8"),  # sheet, surface and meters that it meets next (layout.py)
    ("time", "f8"),  # [durations], where there is a clock
    ("speed", "f8"),  # [scene lengths per duration, or per second], where speeds differ or are looked at
    ("footing", "i8"),  # the facet that it stands on, where it stands on a mesh
    ("facet", "i8"),  # the facet that it meets next
    ("crossed", "i8"),  # the facet of the mesh that it passed last, of a meter
    ("index", "f8"),  # of the medium that it is in, 0 where that is not known
    ("inside", "i8"),  # bits of the bodies that it is in
    ("ahead", "f8"),  # of forced first collisions: what it has to do (forcing.py)
    ("visited", "i8"),  # bits of what it has crossed, where a detector asks `via`
    ("reflections", "i8"),  # where a detector asks for `events`
    ("cell", "i8"),  # of a detector's bins, in which it was born, where histories run backwards
    (
        "told",
        "f8",
    ),  # the greatest density of its direction [sr^-1], where detectors know of it already; else 0 ...
    ("ex", "f8"),  # ... and where it took that direction
    ("ey", "f8"),
    ("ez", "f8"),
)

# What one step computes and the next forgets.
SCRATCH = (
    ("nx", "f8"),
    ("ny", "f8"),
    ("nz", "f8"),
    ("mu", "f8"),  # u·n: negative where the particle comes towards the normal
    ("albedo", "f8"),
    ("ratio", "f8"),  # refractive index behind the surface over that before it
    ("before", "f8"),  # the indices themselves
    ("behind", "f8"),
    ("excess", "f8"),  # (ratio - 1)(ratio + 1)
    ("roughness", "f8"),
    ("through", "f8"),  # the share of what goes on that goes through; 1 or 0 once that is settled
    ("lobe", "f8"),  # cosine at which what microfacets keep back leaves
    ("ox", "f8"),  # where the flight began, in scenes whose surfaces cut one another
    ("oy", "f8"),
    ("oz", "f8"),
    ("left", "i8"),  # the sheet that it began on
    ("rx", "f8"),  # the ray's origin, which what passes through a meter keeps
    ("ry", "f8"),
    ("rz", "f8"),
    ("stood", "i8"),  # and the sheet that it began on, and whether it leaves a box here
    ("u0", "f8"),  # this event's uniforms: 52 bits,
    ("u1", "f8"),  # 32 bits,
    ("u2", "f8"),  # 52 bits, the low ones shared with u1
    ("u3", "f8"),  # 52 bits each, where mixtures or thermal walls need more
    ("u4", "f8"),
    ("arrival", "f8"),  # when it meets what is ahead [durations]
    ("depth", "f8"),  # optical depth of its free path, in scenes with grids
    ("medium", "i8"),  # row of the medium that it is in (layout.MEDIA)
    ("mfp", "f8"),  # its mean free path there [scene lengths]: from extinction, or from scattering alone ...
    ("sigma_a", "f8"),  # ... where absorption lessens weights along the way by this
    ("survival", "f8"),  # the chance that it is scattered where it collides, else absorbed
    ("cut", "i8"),  # 1 where a flight is cut short at a station, or ended there or at a collision
    ("caught", "f8"),  # the weight of a copy whose collision is forced, and its path
    ("path", "f8"),
    ("copies", "i8"),  # how many go into the bank
    ("flies", "i8"),  # 1 where it flies in this round, 0 where it waits for the others
    ("collides", "i8"),  # 0 where it does not, else one more than the number of its phase function
    ("look", "i8"),  # the meter here, in one word (layout.py); 0: none
    ("home", "i8"),  # first row of the meter on the side that is scored
    ("meter", "i8"),  # index of the meter's row
    ("bin", "i8"),  # row to score in; 0: none
    ("high", "i8"),  # the weight to score in units of 2^-32 ...
    ("low", "i8"),  # ... the rest in units of 2^-63 ...
    ("slant", "i8"),  # ... and weight/|mu| in units of 2^-22
    ("reach", "f8"),  # where on the ray a flight ends: at what is next, or when the clock stops
    ("lead", "f8"),  # how far it flies before it is in the volume ...
    ("within", "f8"),  # ... and how far in it
    ("fade", "f8"),  # by which absorption lessens its weight on the way [1/scene lengths] ...
    ("keep", "f8"),  # ... and by which it is absorbed in all, by chance as well
    ("walk_lane", "i8"),  # of a flight through voxels (grids.py): the lane that it is of ...
    ("walk_state", "i8"),  # ... what it is doing ...
    ("walk_history", "i8"),
    ("walk_event", "i8"),
    ("walk_turns", "i8"),  # ... turns that it has taken ...
    ("walk_chance", "f8"),  # ... the number that decides about its next tentative collision ...
    ("walk_draw", "i8"),  # ... random blocks that it has used ...
    ("walk_t", "f8"),  # ... how far it has come ...
    ("walk_end", "f8"),  # ... and where a surface ends it, as distances from x ...
    ("walk_depth", "f8"),  # ... optical depth that is left ...
    ("walk_top", "f8"),  # ... majorant of the macro cell that it is in ...
    ("walk_i", "f8"),  # ... which one ...
    ("walk_j", "f8"),
    ("walk_m", "f8"),
    ("walk_px", "f8"),  # ... its origin and direction in macro cells ...
    ("walk_py", "f8"),
    ("walk_pz", "f8"),
    ("walk_vx", "f8"),
    ("walk_vy", "f8"),
    ("walk_vz", "f8"),
    ("walk_ix", "f8"),  # ... and one over that
    ("walk_iy", "f8"),
    ("walk_iz", "f8"),
    ("walk_cell", "i8"),  # ... its place in the table of majorants
    ("voxel", "i8"),  # number of the voxel where a tentative collision is ...
    ("open", "i8"),  # ... the same where its extinction must be looked up, else 0 ...
    ("sure", "f8"),  # ... the least chance in its macro cell that it is real ...
    ("level", "i8"),  # ... the chance that it is real, in steps
    ("sx", "f8"),  # where a shadow ray begins ...
    ("sy", "f8"),
    ("sz", "f8"),
    ("vx", "f8"),  # ... its direction ...
    ("vy", "f8"),
    ("vz", "f8"),
    ("gap", "f8"),  # ... how far it is to the point detector ...
    ("score", "f8"),  # ... what it brings there if nothing stops it [weight per squared scene length] ...
    ("bent", "f8"),  # ... the cosine of the angle that it is scattered by ...
    ("density", "f8"),  # ... and the density with which it is [sr^-1]
    ("law", "i8"),  # number of the phase function here
    ("stands", "i8"),  # the sheet that the ray begins on
    ("tally", "i8"),  # first row of its point detector
    (
        "leg",
        "i8",
    ),  # one more than the number of that, of a ray that is to be scattered once more on its way; else 0
    ("onset", "f8"),  # where on a ray to a point of a detector, told from there, it begins ...
    ("p0", "f8"),  # ... and the numbers that choose the point
    ("p1", "f8"),
    ("kept", "f8"),  # a lane's weight, while a detector counts less of it
    ("listed", "i8"),  # lanes picked out by a pass
    ("movers", "i8"),
)

Bundle = np.dtype(
    [(name, "i8") for name in HEADER]
    + [("idle", "i8", (HEADER_WORDS - len(HEADER),))]
    + [(name, kind, (PITCH,)) for name, kind in CARRIED + SCRATCH],
    align=True,
)
CARRIED_WORDS = HEADER_WORDS  # where the carried fields begin, in words of 8 bytes


def empty_bundle() -> np.ndarray:
    """A record of idle lanes that knows its own address, aligned to a cache line."""
    memory = np.zeros(Bundle.itemsize + 64, np.uint8)
    offset = -memory.ctypes.data % 64
    bundle = memory[offset : offset + Bundle.itemsize].view(Bundle)
    bundle["address"], bundle["worth"] = bundle.ctypes.data, np.float64(1.0).view(np.int64)
    return bundle
