"""Only the effects that a scene calls for: each shape and each material adds just its own passes and fields."""

import pytest

import transport as tp
from transport.analysis.effects import effects_of

LIGHT = tp.Lambertian(power=1.0)


def room(*surfaces):
    walls = [tp.Surface(face, tp.Diffuse(0.5), name) for name, face in tp.Box(size=4.0).faces().items()]
    return tp.Scene(tp.Source("+z", LIGHT, side="back"), [*walls, *surfaces])


PLAIN = effects_of(room())
MEET = {
    tp.Disk(radius=0.5): {"meet_disk"},
    tp.Triangle(vertices=((0, 0, 0), (1, 0, 0), (0, 1, 0.5))): {"meet_triangle"},
    tp.Plane(center=(0, 0, -3)): {"meet_plane"},
    tp.Rectangle(width=1, height=1, hole=tp.Disk(radius=0.2)): {"meet_holed"},
    tp.Sphere(radius=0.5): {"meet_sphere", "project_onto_sphere"},
    tp.Sphere(radius=0.5, mu_min=0): {"meet_quadric", "project_onto_sphere"},
    tp.Cylinder(radius=0.5, height=1): {"meet_quadric", "project_onto_quadric"},
    tp.Cone(radius=0.5, height=1): {"meet_quadric", "project_onto_quadric"},
    tp.Paraboloid(focal_length=0.5, radius=1): {"meet_quadric", "project_onto_quadric"},
    tp.Mesh.box(size=0.5): {"meet_mesh", "land_on_facet"},
}
ACT = {
    tp.Mirror(): {"reflect_specularly"},
    tp.Diffuse(0.3, 0.3): {"look_up_optics", "sample_transmission", "transmit"},
    tp.Mirror(0.3, 0.3): {"look_up_optics", "sample_transmission", "transmit", "reflect_specularly"},
    tp.Conductor(0.2, 3.4): {"look_up_metal", "reflect_by_metal", "reflect_specularly"},
    tp.Dielectric(1.5): {"look_up_optics", "refract", "set_birth_index"},
    tp.Glossy(0.2): {"look_up_optics", "reflect_glossily", "scatter_into_lobe", "draw_second_block"},
    tp.ThinLens(0.5): {"deflect_by_lens"},
    tp.TwoSided(tp.Diffuse(0.4), tp.Black()): {"choose_material"},
    tp.Mixture({tp.Mirror(): 0.5, tp.Black(): 0.5}): {
        "choose_material",
        "draw_second_block",
        "reflect_specularly",
    },
}


@pytest.mark.parametrize("shape", MEET, ids=lambda shape: type(shape).__name__)
def test_a_shape_adds_its_own_passes_and_no_others(shape):
    added = set(effects_of(room(tp.Surface(shape, tp.Diffuse(0.5)))).passes) - set(PLAIN.passes)
    assert added == MEET[shape]


@pytest.mark.parametrize("material", ACT, ids=lambda material: str(material)[:30])
def test_a_material_adds_its_own_passes_and_no_others(material):
    with_disk = set(effects_of(room(tp.Surface(tp.Disk(radius=0.5), tp.Diffuse(0.4)))).passes)
    added = set(effects_of(room(tp.Surface(tp.Disk(radius=0.5), material))).passes) - with_disk
    assert added == ACT[material]


def test_a_room_of_rectangles_carries_nothing_of_glass_and_meshes():
    of_glass = set(effects_of(room(tp.Surface(tp.Disk(radius=0.5), tp.Dielectric(1.5)))).fields)
    of_mesh = set(effects_of(room(tp.Surface(tp.Mesh.box(size=0.5), tp.Diffuse(0.5)))).fields)
    glass, mesh = (
        {"index", "ratio", "excess", "index_before", "index_behind"},
        {"own_facet", "facet", "passed_facet"},
    )
    assert glass <= of_glass
    assert mesh <= of_mesh
    assert not (glass | mesh) & set(PLAIN.fields)
    assert {"meet_sphere", "meet_quadric", "meet_mesh", "refract", "deflect_by_lens"} <= set(PLAIN.absent)
