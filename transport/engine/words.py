"""Packed words of a lane: `covered` and `sheet` (bits: compile/layout.py), and begun random blocks."""

from functools import cache

from transport.compile import layout
from transport.physics.device import device
from transport.physics.streams import begin_block, begin_event_block, end_block, unpacked


@device
def is_covered(covered, layer):
    """Return whether the detector or boundary in this layer of the sheet covers the point."""
    return ((covered >> layer) & 1) != 0


@device
def standing_sheet(places):
    """Return the sheet that a ray began on. places: the lane's `sheet` word."""
    return places & layout.STANDING_SHEET_MASK


@device
def passed_sheet(places):
    """Return the sheet of the detector that a ray passed last; 0: none."""
    return places >> layout.PASSED_SHIFT


# ---- Random blocks (physics/streams.py): a pass begins one in a loop before its own (`before=`), and its
# body takes the words.


@cache
def birth_block(purpose):
    """Return a body that begins the random block of a birth for one purpose."""

    @device
    def begin(lane, table):
        seed_low, seed_high = lane.seed_low, lane.seed_high
        lane.block_0, lane.block_1 = begin_block(lane.history, lane.batch, 0, purpose, seed_low, seed_high)

    return begin


def event_block(purpose):
    """Return a body that begins the random block of a later event for one purpose."""

    @device
    def begin(lane, table):
        history, event, seed_low, seed_high = lane.history, lane.event, lane.seed_low, lane.seed_high
        lane.block_0, lane.block_1 = begin_event_block(
            history, lane.batch, event, purpose, seed_low, seed_high
        )

    return begin


@device
def words_of_block(lane):
    """Return the four random words of the block that was begun."""
    return end_block(lane.block_0, lane.block_1, lane.seed_low, lane.seed_high)


@device
def words_in_block(lane):
    """Return the four words of a block that holds them whole, as that of a guided birth does."""
    return unpacked(lane.block_0, lane.block_1)
