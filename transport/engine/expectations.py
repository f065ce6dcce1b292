"""The steps of expected crossings: rays that events cast to detectors, what befalls them, and what flights still count."""

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
    """What each birth of an emitter sends to every detector, and whether that was told."""
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
    """What diffuse walls send of what they reflect or let through."""
    for each in plan.expectations:
        if each.walls is not None:
            yield step(expecting.draw_at_event, each.walls)
            yield from _connected(plan, each, each.walls, expecting.expect_from_walls)
    if plan.expectations and plan.reflects:
        yield step(told.tell_walls, _told(LAMBERTIAN))


def expected_of_collisions(plan):
    """What collisions scatter."""
    rows = [(each, each.collisions) for each in plan.expectations if each.collisions is not None]
    if not rows:
        return
    yield step(detours.know_phase_at_collisions, rows_of(plan.media))
    for each, row in rows:
        yield step(expecting.draw_at_event, row)
        yield from _connected(plan, each, row, expecting.expect_from_collisions, phase_densities(plan))
    yield step(told.tell_collisions, _told(float(rows[0][1]["peak"])))


def guards(plan):
    """Flights that no ray tells of, counted where they pass near a detector: they name the surfaces that bring such light."""
    for guard in plan.guards:
        yield step(told.count_in_guard, guard.row)


def _connected(plan, each, row, send, densities=()):
    """A ray from each lane's event to the point that it has drawn, and what it brings."""
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
    """Before a layer's meters count what flights bring: only what no ray has told; nothing where none expects."""
    if expects_on(plan, layer):
        yield step(told.keep_weight)
    for each in plan.expectations:
        if each.layer == layer:
            yield step(told.hold_back, layout.row(layout.HELD, **each.held, passing=passing))


def given_back(plan, layer):
    """After that."""
    if expects_on(plan, layer):
        yield step(told.give_back)


def expects_on(plan, layer):
    """Whether a meter of the layer is told what to expect."""
    return any(each.layer == layer for each in plan.expectations)


def expected_sight(plan, media, members, crossing):
    """The steps of rays; the first has the handle of the bundle that casts them.

    media, members: as flights';  crossing: those from arriving at a surface to leaving it.
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
    """What a ray takes along, from the lane that casts it into its own."""
    moves = [("onset" if name == "start" else source, name) for source, name in RAY]
    moves += [("leg", "leg"), ("history", "history")]
    moves += [("inside", "inside")] * plan.has_bodies + [("footing", "footing")] * bool(plan.meshes)
    moves += [("visited", "visited")] * bool(plan.marks)
    moves += [("reflections", "reflections")] * plan.counts_reflections
    moves += [("cell", "cell")] * (plan.turned is not None)
    return word_moves(plan, moves)


def _told(peak):
    return layout.row(layout.TOLD, peak=peak)
