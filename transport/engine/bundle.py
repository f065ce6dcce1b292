"""A bundle: LANES particles (lanes) in one record, with one fixed-length array per field.

All fields lie at compile-time offsets from one base address, so LLVM knows that they do not overlap and
vectorises the lane loops. A field that no pass of a program uses is never touched and never occupies cache.
"""

import ctypes
import os

import numpy as np
from llvmlite import ir
from numba import carray, config, njit, types
from numba.extending import intrinsic

from transport.scene.detectors import MAX_PATHS

# Lanes per bundle: a constant of the build. Only tests set the environment variable.
LANES = int(os.environ.get("TRANSPORT_LANES", "256"))
# Words from one field to the next: LANES for particles in flight, as many behind them for those that wait at
# a surface (passes/lanes.py), and nine cache lines, so that the fields of one lane do not all fall into the
# same cache set.
PITCH = 2 * LANES + 72

HEADER = (
    "address",  # of this record: lanes are moved as rows of int64
    "copy_rows",  # rows from one copy of the tallies to the next (driver.Sums); 0 where there is one
    "arena",  # address of the buffer that tables lie in, and the arrays that they refer to (compile.arena)
    "tallies",  # address of the batch's detector sums (rows of four int64)
    "sizes",  # address of the batch's histogram of score sizes
    "moments",  # address of the long sums, such as of velocities (rows of four limbs)
    "records",  # address of the recorded snapshot states (layout.RECORD)
    "record_count",  # number of states recorded so far
    "stride",  # one in `stride` histories is recorded ...
    "record_phase",  # ... namely those with history % stride == phase
    "tracks",  # address of the recorded flight segments of tracks (layout.PATH_SEGMENT)
    "tracks_capacity",  # number of segments that fit there
    "flight_count",  # number of segments flown, recorded or not
    "ledger",  # address of the batch's energy balance (rows of four int64)
    "ledger_words",  # length of that array in int64 words
    "seed_low",  # lower 32 bits of the seed
    "seed_high",  # upper 32 bits of the seed
    "batch",  # number of the batch: part of every random counter
    "next_history",  # number of the history of a newborn lane 0
    "birth_factor",  # float64 bits: factor of the current emitter's birth weights (driver._deal_histories)
    "started",  # histories born so far; other threads may read it while the bundle runs
    "crossings",  # surface crossings so far
    "collisions",  # collisions in media so far
    "flying",  # lanes in flight, in programs with collisions ...
    "waiting",  # ... and lanes that wait at a surface, from LANES on (passes/lanes.py)
    "bank",  # address of the particle bank: copies that wait for a free lane
    "banked",  # number of copies in the bank
    "bank_capacity",  # capacity of the bank in copies
    "bank_overflow",  # 1: the bank overflowed; > 1: number of copies made, where too many; else 0
    "scored",  # bound of the sums of volume, point and expected-crossing scores (driver.MAX_SCORED)
    "births",  # address of what each history was born from (layout.BIRTH_RECORD), to learn a guide ...
    "brought",  # ... and of the sums of its scores (float64)
    "shadow",  # address of the bundle of shadow rays, where point or expected detectors exist
    "rays_cast",  # number of rays that the last casting pass listed ...
    "rays_taken",  # ... and how many of these are already in the shadow bundle
    "killed",  # histories ended after too many events (surfaces.kill_endless)
    "patience",  # crossings within which some history must end or lose weight (driver.PATIENCE) ...
    "patience_in_media",  # ... and collisions
    "trapped",  # number of lanes if none has ended or lost weight for so long, else 0
    "stop",  # set by another thread: end before the batch is complete
    "zero",  # 0, which the compiler does not know (bodies._set_lane_field)
)
# Whole cache lines, so that every field of lanes begins on a line.
HEADER_WORDS = -(-len(HEADER) // 8) * 8

# State carried by a particle: a program moves only the fields that its passes use.
CARRIED = (
    ("x", "f8"),  # position [scene lengths]
    ("y", "f8"),
    ("z", "f8"),
    ("ux", "f8"),  # unit direction
    ("uy", "f8"),
    ("uz", "f8"),
    ("weight", "f8"),  # statistical weight [largest birth weight of the scene]; 0: the lane is idle
    ("birth", "f8"),  # reference weight for Russian roulette and splitting: the weight at birth
    ("history", "i8"),  # number within the batch; a copy has a hash with bit 55 set (engine/passes/bank.py)
    ("event", "i8"),  # grows with every event: a word of the counter from which random numbers are drawn
    # sheet that the lane stands on, and the detector's sheet passed last (layout.STANDING_SHEET_MASK)
    ("sheet", "i8"),
    ("start", "f8"),  # ray parameter of the particle: 0, or < 0 for an aimed particle whose x is its target
    ("distance", "f8"),  # ray parameter of the next surface or collision
    ("hit", "i8"),  # the next sheet, its acting surface and material (layout.PARTS); 0: none
    ("covered", "i8"),  # bits of the detectors and boundaries that cover its point (layout.py)
    ("time", "f8"),  # [durations], in scenes with a clock
    ("speed", "f8"),  # [scene lengths per duration, or per second], where speeds differ or are scored
    ("own_facet", "i8"),  # facet that the lane stands on, where it stands on a mesh
    ("facet", "i8"),  # facet of the next hit
    ("passed_facet", "i8"),  # facet of the transparent mesh detector passed last
    ("index", "f8"),  # refractive index of the current medium, 0 where it is not known
    ("inside", "i8"),  # bit set of the bodies that contain the particle
    # the current medium, which collisions do not change
    ("medium", "i8"),  # row of the current medium (layout.MEDIA)
    ("mfp", "f8"),  # mean free path there [scene lengths]: of extinction, or of scattering alone ...
    ("sigma_a", "f8"),  # ... where this absorption coefficient lessens weights along the path
    ("survival", "f8"),  # probability that a collision scatters rather than absorbs
    # state of forced first collisions (engine/passes/variance_reduction.py): -1 (uncollided), 0 (free), or
    # the path of a forced copy
    ("forced_path", "f8"),
    ("visited", "i8"),  # bit set of the objects crossed, where a detector has `via`
    ("reflections", "i8"),  # reflections and scatterings so far, where a detector has `events`
    # backward runs: bin of the detector in which the history was born; -1 - k if it was born at lamp k
    ("cell", "i8"),
    ("began", "i8"),  # first interaction (layout.UNBEGUN), where some start at lamps (compile/caustics.py)
    ("path_density", "f8"),  # of such histories, per area and projected solid angle
    ("born", "i8"),  # number of the history that was born, where its scores are added up; copies keep it
    # MIS state of next-event estimation: largest pdf of the last sampled direction [sr^-1], 0 if no ray could
    # have scored that path ...
    ("mis_pdf", "f8"),
    ("ex", "f8"),  # ... and the point where the direction was sampled
    ("ey", "f8"),
    ("ez", "f8"),
    # path lengths by medium [scene lengths], where a detector has `path_lengths` (engine/passes/paths.py)
    *((f"path_{k}", "f8") for k in range(MAX_PATHS)),
)

# Values that one step computes and the next forgets.
SCRATCH = (
    ("nx", "f8"),  # unit normal at the hit
    ("ny", "f8"),
    ("nz", "f8"),
    ("mu", "f8"),  # u·n: negative where the particle moves against the normal
    ("albedo", "f8"),  # share of the weight that the surface does not absorb
    ("ratio", "f8"),  # refractive index behind the surface over that before it
    ("index_before", "f8"),  # refractive index on the side of arrival
    ("index_behind", "f8"),  # refractive index on the other side
    ("excess", "f8"),  # (ratio - 1)(ratio + 1)
    ("roughness", "f8"),  # GGX alpha
    ("transmitted", "f8"),  # transmitted share of the remaining weight; 1 or 0 once sampled
    ("lobe", "f8"),  # azimuth uniform of the multiple-scattering lobe of microfacets; 2: not taken
    ("lobe_peak", "f8"),  # largest pdf of that lobe [sr^-1]; 0 where no ray is sent from microfacets
    ("ax", "f8"),  # direction of arrival at a glossy surface that sends rays
    ("ay", "f8"),
    ("az", "f8"),
    ("ox", "f8"),  # origin of the flight, in scenes whose surfaces cut or touch one another
    ("oy", "f8"),
    ("oz", "f8"),
    ("flight_sheet", "i8"),  # sheet that the flight began on
    ("rx", "f8"),  # origin of the ray, restored after a transparent detector
    ("ry", "f8"),
    ("rz", "f8"),
    ("ray_sheet", "i8"),  # sheet that the ray began on, and the bit layout.LEFT_BOX if it leaves a box here
    ("block_0", "i8"),  # a begun random block (physics/streams.py): words 0 and 1 ...
    ("block_1", "i8"),  # ... and words 2 and 3
    ("u0", "f8"),  # uniform random numbers of this event: 52 bits,
    ("u1", "f8"),  # 32 bits,
    ("u2", "f8"),  # 52 bits, the low ones shared with u1
    ("u3", "f8"),  # 52 bits each, for mixtures and thermal walls
    ("u4", "f8"),
    ("worth", "f8"),  # weight of a guided birth
    ("arrival", "f8"),  # time at the end of the flight [durations]
    ("depth", "f8"),  # uniform of the free path, then, where that is needed, its optical depth
    ("cut", "i8"),  # 1 if a flight is cut at a station, or ended there or at a collision
    ("copy_weight", "f8"),  # weight of the copy whose collision is forced ...
    ("copy_path", "f8"),  # ... and its path length
    ("copies", "i8"),  # number of copies that go into the bank
    ("collides", "i8"),  # 0: no collision; else number of the phase function (from 1)
    ("detector_word", "i8"),  # packed word of the detector at this crossing (layout.py); 0: none
    ("detector_row", "i8"),  # first row of that detector on the side that is scored
    ("detector_index", "i8"),  # index of the detector's row in layout.DETECTOR
    ("bin", "i8"),  # tally row to score into; 0: none
    ("high", "i8"),  # weight to score in units of 2^-32 ...
    ("low", "i8"),  # ... its remainder in units of 2^-63 ...
    ("count", "i8"),  # ... number, and above it grazing crossings (tally.count_of_score)
    ("slant", "i8"),  # ... and weight/|mu| in units of 2^-22
    ("flight_end", "f8"),  # ray parameter at the end of a flight: the next hit, or where the clock stops
    ("length_before", "f8"),  # path length before the flight enters the volume detector ...
    ("length_inside", "f8"),  # ... and inside it
    ("left", "f8"),  # weight that a medium's absorption leaves
    # absorption coefficient that lessens the weight along the path [1/scene lengths] ...
    ("path_absorption", "f8"),
    ("total_absorption", "f8"),  # ... and the total one, with absorption at collisions
    ("walk_lane", "i8"),  # delta tracking through voxels (engine/passes/voxels.py): lane of this walk ...
    ("walk_state", "i8"),  # ... its state ...
    ("walk_history", "i8"),
    ("walk_event", "i8"),
    ("walk_turns", "i8"),  # ... number of turns taken ...
    ("walk_uniform", "f8"),  # ... uniform that decides about its next tentative collision ...
    ("walk_draw", "i8"),  # ... random blocks used ...
    ("walk_t", "f8"),  # ... its ray parameter ...
    ("walk_end", "f8"),  # ... and that of the surface that ends it ...
    ("walk_depth", "f8"),  # ... remaining optical depth ...
    ("walk_majorant", "f8"),  # ... majorant of the current macro cell ...
    ("walk_i", "f8"),  # ... indices of that cell ...
    ("walk_j", "f8"),
    ("walk_m", "f8"),
    ("walk_px", "f8"),  # ... origin in units of macro cells ...
    ("walk_py", "f8"),
    ("walk_pz", "f8"),
    ("walk_vx", "f8"),  # ... direction in macro cells per scene length ...
    ("walk_vy", "f8"),
    ("walk_vz", "f8"),
    ("walk_ix", "f8"),  # ... and its reciprocal ...
    ("walk_iy", "f8"),
    ("walk_iz", "f8"),
    ("walk_cell", "i8"),  # ... index of the cell in the table of majorants
    ("voxel", "i8"),  # number of the voxel of a tentative collision ...
    ("lookup_voxel", "i8"),  # ... the same where its extinction must be looked up, else 0 ...
    ("sure_probability", "f8"),  # ... smallest probability in the macro cell that a collision is real ...
    ("level", "i8"),  # ... and that probability in the voxel, in steps of 1/layout.LEVELS
    ("sx", "f8"),  # point on a shadow ray where its parameter is 0 ...
    ("sy", "f8"),
    ("sz", "f8"),
    ("vx", "f8"),  # ... its unit direction ...
    ("vy", "f8"),
    ("vz", "f8"),
    ("ray_start", "f8"),  # ... ray parameters of its origin ...
    ("point_distance", "f8"),  # ... and of its end: a point detector, a scattering point, or infinity ...
    ("score", "f8"),  # ... connection factor, then unoccluded contribution ...
    ("scatter_cosine", "f8"),  # ... cosine of its scattering angle ...
    ("pdf", "f8"),  # ... and pdf of that direction [sr^-1]
    ("phase_number", "i8"),  # number of the phase function here; 0: none
    ("shadow_sheet", "i8"),  # sheet that the ray begins on
    ("tally", "i8"),  # first row of its detector
    # mark of a shadow ray (layout.STRAIGHT_LEG)
    ("leg", "i8"),
    ("p0", "f8"),  # uniforms that choose the point on a detector
    ("p1", "f8"),
    ("full_weight", "f8"),  # full weight of a lane, while a detector scores an MIS share of it
    ("leaves", "i8"),  # 1 for lanes that do not fly on in their medium (passes/lanes.py)
    ("listed", "i8"),  # indices of the lanes selected by a pass
    ("movers", "i8"),  # indices of the lanes that fill gaps
)

Bundle = np.dtype(
    [(name, "i8") for name in HEADER]
    + [("idle", "i8", (HEADER_WORDS - len(HEADER),))]
    + [(name, kind, (PITCH,)) for name, kind in CARRIED + SCRATCH],
    align=True,
)
CARRIED_WORDS = HEADER_WORDS  # offset of the carried fields in words of 8 bytes


def header_of(bundle: np.ndarray) -> np.ndarray:
    """Return the words of a bundle's header, in the order of HEADER, without a copy."""
    return np.frombuffer(bundle, np.int64, len(HEADER))


def empty_bundle() -> np.ndarray:
    """Return a record of idle lanes, aligned to a cache line, whose `address` is its own."""
    memory = np.zeros(Bundle.itemsize + 64, np.uint8)
    offset = -memory.ctypes.data % 64
    bundle = memory[offset : offset + Bundle.itemsize].view(Bundle)
    bundle["address"], bundle["birth_factor"] = bundle.ctypes.data, np.float64(1.0).view(np.int64)
    return bundle


# ---- Raw addresses: call a pass by address, view memory as an array, add to a row; with plain Python twins
# for NUMBA_DISABLE_JIT=1.
#
# driver.run_batch keeps the memory alive: the arena and the sums.


@intrinsic
def _pointer(typing_context, address):
    """Convert an address (int64) to a void pointer."""

    def codegen(context, builder, signature, args):
        return builder.inttoptr(args[0], ir.IntType(8).as_pointer())

    return types.voidptr(types.int64), codegen


@intrinsic
def _call_pass(typing_context, entry, bundle, offset, first, live):
    """Call the compiled pass at address `entry` as (bundle, offset of its table, first, live); returns the
    number of live lanes.
    """

    def codegen(context, builder, signature, args):
        pointer, integer = ir.IntType(8).as_pointer(), ir.IntType(64)
        function = ir.FunctionType(integer, [pointer, integer, integer, integer]).as_pointer()
        bundle = builder.inttoptr(args[1], pointer)
        return builder.call(builder.inttoptr(args[0], function), [bundle, *args[2:]])

    return types.int64(types.int64, types.int64, types.int64, types.int64, types.int64), codegen


@intrinsic
def _add_to_row(typing_context, address, first, second, third, fourth):
    """Add four int64 words to the row of four at `address`, by one 32-byte load, addition and store."""

    def codegen(context, builder, signature, args):
        row = ir.VectorType(ir.IntType(64), 4)
        added = ir.Constant(row, ir.Undefined)
        for i, word in enumerate(args[1:]):
            added = builder.insert_element(added, word, ir.IntType(32)(i))
        pointer = builder.inttoptr(args[0], row.as_pointer())
        builder.store(builder.add(builder.load(pointer, align=8), added), pointer, align=8)
        return context.get_dummy_value()

    return types.void(types.int64, types.int64, types.int64, types.int64, types.int64), codegen


def _add_to_row_plain(address, *words):
    """Twin of `_add_to_row` in plain Python."""
    row = _view_plain(address, 4, np.int64)
    row += np.array(words, np.int64)


@njit(inline="always")
def _view(address, count, dtype):
    """View `count` items of `dtype` at `address` as an array, without a copy."""
    return carray(_pointer(address), (count,), dtype)


def _view_plain(address, count, dtype):
    """Twin of `_view` in plain Python; records become a recarray."""
    memory = (ctypes.c_char * (int(count) * np.dtype(dtype).itemsize)).from_address(int(address))
    return np.frombuffer(memory, dtype).view(np.recarray if np.dtype(dtype).names else np.ndarray)


def _call_pass_plain(entry, bundle, offset, first, live):
    """Twin of `_call_pass` in plain Python: `entry` is the Python function itself."""
    return entry(bundle, offset, first, live)


view = _view_plain if config.DISABLE_JIT else _view
call_pass = _call_pass_plain if config.DISABLE_JIT else _call_pass
add_to_row = _add_to_row_plain if config.DISABLE_JIT else _add_to_row


# ---- A bundle for plain Python (NUMBA_DISABLE_JIT=1), in which `b.weight[k]` is 25 times as fast as on a
# NumPy record.


class PlainRecord:
    """The single record of an array: array fields are views, scalar fields are read and written in place."""

    def __init__(self, array: np.ndarray) -> None:
        record = array[0]
        arrays = {name: record[name] for name in array.dtype.names if array.dtype[name].shape}
        vars(self).update(arrays, _record=record)

    def __getattr__(self, name: str):
        return vars(self)["_record"][name]

    def __setattr__(self, name: str, value) -> None:
        vars(self)["_record"][name] = value
