"""Steps of next-event estimation for surface detectors: cast rays, trace them, weight flights by MIS."""

from transport.compile import layout
from transport.compile.expected import LAMBERTIAN
from transport.compile.points import dims_anywhere, phase_densities
from transport.engine import births, casting, detours, expected_rays, expecting, shadows, told
from transport.engine.lookouts import MOVES as RAY
from transport.engine.lookouts import word_moves
from transport.engine.registry import named, rows_of, step
from transport.shapes import Disk, Rectangle, Sphere, Triangle

POINTS = {Rectangle: "point_on_rectangle", Disk: "point_on_disk", Triangle: "point_on_triangle"}


def expected_of_births(plan, emitter):
    """Yield the steps that cast rays from births to every detector, and record the pdf for MIS."""
    number = next(k for k, each in enumerate(plan.emitters) if each is emitter)
    rows = [(each, each.births[number]) for each in plan.expectations if each.births[number] is not None]
    if rows and emitter.facing is not None and emitter.law[0] == "emit_lambertian_from_plane":
        yield step(births.take_normal, emitter.facing)
    for each, row in rows:
        yield step(expecting.draw_at_birth, row) if row["number"] else step(expecting.draw_first_at_birth)
        yield from _connected(plan, each, row, expecting.expect_from_births)
    if plan.expectations:
        yield step(told.tell_births, _told(float(rows[0][1]["peak"]) if rows else 0.0))


def expected_of_walls(plan):
    """Yield the steps that cast rays from diffuse walls, and record the pdf for MIS."""
    for each in plan.expectations:
        if each.walls is not None:
            yield step(expecting.draw_at_event, each.walls)
            yield from _connected(plan, each, each.walls, expecting.expect_from_walls)
    if plan.expectations and plan.reflects:
        yield step(told.tell_walls, _told(LAMBERTIAN))


def expected_of_collisions(plan):
    """Yield the steps that cast rays from collisions, and record the pdf for MIS."""
    rows = [(each, each.collisions) for each in plan.expectations if each.collisions is not None]
    if not rows:
        return
    yield step(detours.know_phase_at_collisions, rows_of(plan.media))
    for each, row in rows:
        yield step(expecting.draw_at_event, row)
        yield from _connected(plan, each, row, expecting.expect_from_collisions, phase_densities(plan))
    yield step(told.tell_collisions, _told(float(rows[0][1]["peak"])))


def guards(plan):
    """Yield the steps that count flights without a next-event ray near a detector.

    The counts identify the surfaces that send such light.
    """
    for guard in plan.guards:
        yield step(told.count_in_guard, guard.row)


def _connected(plan, each, row, send, densities=()):
    """Yield the steps of a ray from each lane's event to the sampled point, and of its contribution."""
    shape = plan.scene.shape_of(each.detector)
    if isinstance(shape, Sphere):
        yield step(expecting.connect_to_ball, row)
    else:
        yield named((POINTS[type(shape)], row))
        yield step(expecting.connect_to_flat, row)
    yield step(send, row)
    yield from map(named, densities)
    yield step(casting.list_shadows, layout.row(layout.CODE, code=row["legs"]))


def held_back(plan, layer, passing):
    """Yield the steps that apply MIS weights before a layer's detectors score flights.

    There are none without next-event estimation.
    """
    if expects_on(plan, layer):
        yield step(told.keep_weight)
    for each in plan.expectations:
        if each.layer == layer:
            yield step(told.hold_back, layout.row(layout.HELD, **each.held, passing=passing))


def given_back(plan, layer):
    """Yield the step that restores the full weights afterwards."""
    if expects_on(plan, layer):
        yield step(told.give_back)


def expects_on(plan, layer):
    """Return whether next-event estimation applies to a detector of the layer."""
    return any(each.layer == layer for each in plan.expectations)


def expected_sight(plan, media, members, crossing):
    """Yield the steps of next-event rays; the first has the handle of the bundle that casts them.

    media, members: as those of flights. crossing: from arrival at a surface to its other side.
    """
    yield step(shadows.take_shadows, rows_of(_moves(plan)))
    yield step(shadows.look_for_point)
    yield from media
    yield from members
    yield step(expected_rays.end_unmet)
    if plan.has_media and dims_anywhere(plan):
        yield step(shadows.dim)
    for row in (*plan.grids, *plan.thinning_grids):
        yield step(shadows.dim_in_grid, row)
    yield from crossing


def _moves(plan):
    """Return the moves of fields from the casting lane into the ray's lane."""
    moves = [("onset" if name == "start" else source, name) for source, name in RAY]
    moves += [("leg", "leg"), ("history", "history")]
    moves += [("inside", "inside")] * plan.has_bodies + [("footing", "footing")] * bool(plan.meshes)
    moves += [("visited", "visited")] * bool(plan.marks)
    moves += [("reflections", "reflections")] * plan.counts_reflections
    moves += [("cell", "cell")] * (plan.turned is not None)
    return word_moves(plan, moves)


def _told(peak):
    """Return the table with the largest pdf of sampled directions."""
    return layout.row(layout.TOLD, peak=peak)
